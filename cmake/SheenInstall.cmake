# SPDX-License-Identifier: Apache-2.0
# What `cmake --install` puts where: the program, its manual page (where scdoc can make it), the documents.
if(TARGET sheen)
  install(TARGETS sheen RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

find_program(SCDOC scdoc)
file(GLOB manuals CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/docs/*.1.scd)
if(SCDOC AND manuals)
  foreach(manual ${manuals})
    get_filename_component(page ${manual} NAME_WLE) # sheen.1.scd -> sheen.1
    set(made ${PROJECT_BINARY_DIR}/${page})
    add_custom_command(OUTPUT ${made} COMMAND sh -c "'${SCDOC}' < '${manual}' > '${made}'" DEPENDS ${manual} VERBATIM)
    list(APPEND pages ${made})
  endforeach()
  add_custom_target(sheen_man ALL DEPENDS ${pages})
  install(FILES ${pages} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endif()

file(GLOB documents CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/README.md ${PROJECT_SOURCE_DIR}/docs/*.md)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${documents} DESTINATION ${CMAKE_INSTALL_DOCDIR})

# Where udev reads rules: /usr/lib/udev below the prefix /usr, elsewhere below the prefix (a link or copy in
# /etc/udev/rules.d makes it count).
set(SHEEN_UDEV_RULES_DIR lib/udev/rules.d CACHE STRING "Folder for udev's rules, below the prefix or absolute")
install(FILES ${PROJECT_SOURCE_DIR}/udev/60-sheen.rules DESTINATION ${SHEEN_UDEV_RULES_DIR})
