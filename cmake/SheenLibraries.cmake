# SPDX-License-Identifier: Apache-2.0
# The libraries that sheen stands on, as imported targets lib::<name>. All are Debian 12 packages
# (tools/packages.txt). Headers are included as system headers, so that our warnings stay ours.

# sheen_library(<target> HEADER <file> LIBRARIES <names> [SUFFIXES <include path suffixes>])
function(sheen_library target)
  cmake_parse_arguments(L "" "HEADER" "LIBRARIES;SUFFIXES" ${ARGN})
  find_path(${target}_INCLUDE ${L_HEADER} PATH_SUFFIXES ${L_SUFFIXES} REQUIRED)
  add_library(lib::${target} INTERFACE IMPORTED)
  target_include_directories(lib::${target} SYSTEM INTERFACE ${${target}_INCLUDE})
  foreach(name ${L_LIBRARIES})
    find_library(${target}_${name}_LIBRARY ${name} REQUIRED)
    target_link_libraries(lib::${target} INTERFACE ${${target}_${name}_LIBRARY})
  endforeach()
endfunction()

sheen_library(jansson HEADER jansson.h LIBRARIES jansson)
sheen_library(xxhash HEADER xxhash.h LIBRARIES xxhash)
sheen_library(yaml HEADER yaml.h LIBRARIES yaml)
sheen_library(png HEADER png.h LIBRARIES png)
sheen_library(jpeg HEADER jpeglib.h LIBRARIES jpeg)
sheen_library(tiff HEADER tiffio.h LIBRARIES tiff)
sheen_library(openexr HEADER OpenEXR/openexr.h LIBRARIES OpenEXRCore)
sheen_library(mrcal HEADER mrcal/mrcal.h LIBRARIES mrcal)
sheen_library(cholmod HEADER suitesparse/cholmod.h LIBRARIES cholmod)
sheen_library(apriltag HEADER apriltag/apriltag.h LIBRARIES apriltag)
sheen_library(embree HEADER embree3/rtcore.h LIBRARIES embree3)
sheen_library(opencv_imgproc HEADER opencv2/imgproc.hpp SUFFIXES opencv4 LIBRARIES opencv_imgproc opencv_core)
