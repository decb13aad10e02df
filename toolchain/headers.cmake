# Headers from outside that most files of a room include, parsed once for all of them: file by file
# they were a quarter of a build. Files still name what they use: clang's builds, and those for other
# machines, hold them to that, for there nothing is parsed beforehand.
#
# gcc's alone: clang writes the folder of the build into its own, and a clone elsewhere would find
# none of its objects in ccache again.
set(standard
  <algorithm> <array> <atomic> <bit> <cassert> <chrono> <cmath> <cstdint> <cstdio> <cstdlib>
  <cstring> <limits> <memory> <numbers> <optional> <span> <string> <string_view> <utility> <vector>)
set(eigen <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU>)
# Not CLI11: it has objects of its own, which every file would make anew.
set(host
  <deque> <filesystem> <fstream> <functional> <map> <nlohmann/json.hpp> <set> <sstream> <thread>)

# pipewright_headers(NAME [DEPENDS ...] HEADERS ...): parsed for targets by pipewright_parse_once.
function(pipewright_headers name)
  cmake_parse_arguments(ARG "" "" "DEPENDS;HEADERS" ${ARGN})
  set(nothing ${CMAKE_CURRENT_BINARY_DIR}/${name}.cc)
  file(CONFIGURE OUTPUT ${nothing} CONTENT "")
  add_library(${name} OBJECT ${nothing})
  target_link_libraries(${name} PRIVATE Eigen3::Eigen ${ARG_DEPENDS} pipewright_options)
  target_precompile_headers(${name} PRIVATE ${ARG_HEADERS})
endfunction()

pipewright_headers(parsed_headers HEADERS ${standard} ${eigen})
if(PIPEWRIGHT_HOST)
  pipewright_headers(parsed_host_headers HEADERS ${standard} ${eigen} ${host})
  pipewright_headers(parsed_test_headers
    DEPENDS GTest::gtest HEADERS ${standard} ${eigen} ${host} <gtest/gtest.h>)
endif()

# ccache finds an object made with such headers only if told where gcc took them, and if clang leaves
# the time of day out of them.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
  target_compile_options(pipewright_options INTERFACE -fpch-preprocess)
else()
  target_compile_options(pipewright_options INTERFACE "SHELL:-Xclang -fno-pch-timestamp")
endif()
