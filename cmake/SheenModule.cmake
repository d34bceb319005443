# SPDX-License-Identifier: Apache-2.0
# sheen_flags: what every one of our targets is compiled with. sheen_module(): one layer's library.
find_package(Threads REQUIRED)

add_library(sheen_flags INTERFACE)
target_compile_definitions(sheen_flags INTERFACE _POSIX_C_SOURCE=200809L)
target_include_directories(sheen_flags INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(sheen_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wcast-qual -Wwrite-strings -Wformat=2 -Wundef -Wvla -Werror=vla
  -Wimplicit-fallthrough -Wnull-dereference -Wpointer-arith
  $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes -Wmissing-prototypes -Wold-style-definition>
  # clang's -Wdouble-promotion dislikes NAN, which is a float, in a double.
  $<$<C_COMPILER_ID:GNU>:-Wdouble-promotion -Wlogical-op -Wduplicated-cond -Wduplicated-branches>
  # Loops marked `omp simd` are vectorised without an OpenMP runtime; results repeat between builds.
  -fopenmp-simd -fno-math-errno -fno-trapping-math -ffp-contract=off
  $<$<BOOL:${SHEEN_WERROR}>:-Werror>)
if(SHEEN_SANITIZE)
  # Their checks keep clang from vectorising what it is asked to; in other builds that stays an error.
  target_compile_options(sheen_flags INTERFACE $<$<C_COMPILER_ID:Clang>:-Wno-pass-failed>
    -fsanitize=${SHEEN_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(sheen_flags INTERFACE -fsanitize=${SHEEN_SANITIZE})
endif()
target_link_libraries(sheen_flags INTERFACE m Threads::Threads)

# sheen_module(<name> SOURCES ... [USES <lower modules>] [LIBS <external targets>])
function(sheen_module name)
  cmake_parse_arguments(M "" "" "SOURCES;USES;LIBS" ${ARGN})
  if(M_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "sheen_module(${name}): what is ${M_UNPARSED_ARGUMENTS}?")
  endif()
  add_library(sheen_${name} STATIC ${M_SOURCES})
  list(TRANSFORM M_USES PREPEND sheen_)
  target_link_libraries(sheen_${name} PUBLIC ${M_USES} PRIVATE ${M_LIBS} sheen_flags)
endfunction()
