# SPDX-License-Identifier: Apache-2.0
# The web viewer (view/), built by npm and esbuild in the build folder and embedded in the program as a C array.
# Sets SHEEN_VIEWER_SOURCE; without nodejs and npm that is an empty page, and SHEEN_HAS_VIEWER is not set.
option(SHEEN_VIEWER "Build the web viewer with nodejs and npm, where they are there" ON)
find_program(SHEEN_NODE NAMES node nodejs)
find_program(SHEEN_NPM npm)
set(SHEEN_VIEWER_SOURCE ${PROJECT_BINARY_DIR}/view/viewer_html.c)

if(SHEEN_VIEWER AND SHEEN_NODE AND SHEEN_NPM)
  set(SHEEN_HAS_VIEWER TRUE)
  set(viewer_work ${PROJECT_BINARY_DIR}/view/work)
  file(GLOB viewer_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/view/*)
  # What npm brings stays in the build folder, and only the locked versions are taken; nothing of it is run on
  # arrival.
  add_custom_command(OUTPUT ${viewer_work}/installed
    COMMAND ${CMAKE_COMMAND} -E make_directory ${viewer_work}
    COMMAND ${CMAKE_COMMAND} -E copy
      ${PROJECT_SOURCE_DIR}/view/package.json ${PROJECT_SOURCE_DIR}/view/package-lock.json ${viewer_work}
    COMMAND ${SHEEN_NPM} --prefix ${viewer_work} ci --omit=dev --ignore-scripts --no-audit --no-fund --loglevel=error
    COMMAND ${CMAKE_COMMAND} -E touch ${viewer_work}/installed
    DEPENDS ${PROJECT_SOURCE_DIR}/view/package.json ${PROJECT_SOURCE_DIR}/view/package-lock.json
    COMMENT "Fetching what the web viewer is built from" VERBATIM)
  add_custom_command(OUTPUT ${SHEEN_VIEWER_SOURCE}
    COMMAND ${CMAKE_COMMAND} -E copy ${viewer_sources} ${viewer_work}
    COMMAND ${SHEEN_NODE} ${viewer_work}/build.mjs ${SHEEN_VIEWER_SOURCE}
    DEPENDS ${viewer_sources} ${viewer_work}/installed
    COMMENT "Building the web viewer" VERBATIM)
else()
  message(STATUS "No web viewer in this build (it wants nodejs and npm): sheen export will not write pages")
  file(CONFIGURE OUTPUT ${SHEEN_VIEWER_SOURCE} CONTENT
    "#include \"cli/viewer_html.h\"\n\nconst char sheen_viewer_html[] = \"\";\n")
endif()
