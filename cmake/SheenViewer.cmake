# SPDX-License-Identifier: Apache-2.0
# The web viewer (view/), built by npm and esbuild in the build folder and embedded in the program as a C array.
# Sets SHEEN_VIEWER_SOURCE; without nodejs and npm that is an empty page, and SHEEN_HAS_VIEWER is not set.
option(SHEEN_VIEWER "Build the web viewer with nodejs and npm, where they are there" ON)
find_program(SHEEN_NODE NAMES node nodejs)
find_program(SHEEN_NPM npm)
set(SHEEN_VIEWER_SOURCE ${PROJECT_BINARY_DIR}/view/viewer_html.c)

# What npm brings stays in the build folder, and only the locked versions are taken; nothing of it is run on arrival.
# Fetched when cmake runs, so that a build without network is a build without viewer rather than none.
set(viewer_work ${PROJECT_BINARY_DIR}/view/work)
set(viewer_stamp ${viewer_work}/installed)
if(SHEEN_VIEWER AND SHEEN_NODE AND SHEEN_NPM)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/view/package-lock.json)
  file(SHA256 ${PROJECT_SOURCE_DIR}/view/package-lock.json viewer_lock)
  set(viewer_have "")
  if(EXISTS ${viewer_stamp})
    file(READ ${viewer_stamp} viewer_have)
  endif()
  if(NOT viewer_have STREQUAL viewer_lock)
    message(STATUS "Fetching what the web viewer is built from")
    file(MAKE_DIRECTORY ${viewer_work})
    file(COPY ${PROJECT_SOURCE_DIR}/view/package.json ${PROJECT_SOURCE_DIR}/view/package-lock.json
      DESTINATION ${viewer_work})
    execute_process(
      COMMAND ${SHEEN_NPM} --prefix ${viewer_work} ci --omit=dev --ignore-scripts --no-audit --no-fund --loglevel=error
      WORKING_DIRECTORY ${viewer_work} RESULT_VARIABLE viewer_failed TIMEOUT 300)
    if(viewer_failed)
      message(WARNING "No web viewer in this build: npm could not fetch what view/package-lock.json names. "
        "Run cmake again when the network is back.")
    else()
      file(WRITE ${viewer_stamp} ${viewer_lock})
      set(viewer_have ${viewer_lock})
    endif()
  endif()
  if(viewer_have STREQUAL viewer_lock)
    set(SHEEN_HAS_VIEWER TRUE)
  endif()
else()
  message(STATUS "No web viewer in this build (it wants nodejs and npm): sheen export will not write pages")
endif()

if(SHEEN_HAS_VIEWER)
  file(GLOB viewer_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/view/*)
  add_custom_command(OUTPUT ${SHEEN_VIEWER_SOURCE}
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer_sources} ${viewer_work}
    COMMAND ${SHEEN_NODE} ${viewer_work}/build.mjs ${SHEEN_VIEWER_SOURCE}
    DEPENDS ${viewer_sources} ${viewer_stamp}
    COMMENT "Building the web viewer" VERBATIM)
else()
  # Another file than the built page: turning the viewer on later must not find this one newer than its sources.
  set(SHEEN_VIEWER_SOURCE ${PROJECT_BINARY_DIR}/view/no_viewer_html.c)
  file(CONFIGURE OUTPUT ${SHEEN_VIEWER_SOURCE} CONTENT
    "#include \"cli/viewer_html.h\"\n\nconst char sheen_viewer_html[] = \"\";\nconst char sheen_pick_html[] = \"\";\n")
endif()
