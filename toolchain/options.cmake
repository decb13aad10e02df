# Compiler options of every target: warnings as errors, and arithmetic that gives one result
# everywhere (no contraction to FMA, no fast-math).
add_library(pipewright_options INTERFACE)
target_compile_options(pipewright_options INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wno-sign-conversion -Wshadow -Wnon-virtual-dtor
  -Werror -ffp-contract=off -fno-math-errno)
# gcc 12 takes std::string's own copies for ones out of bounds (its bug 105329, mended in 13), here and
# there as it inlines. clang's builds look for such with ASan.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  target_compile_options(pipewright_options INTERFACE
    -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread)
endif()
target_include_directories(pipewright_options INTERFACE ${PROJECT_SOURCE_DIR})
# Eigen must neither allocate for small temporaries behind our back nor spawn threads.
target_compile_definitions(pipewright_options INTERFACE EIGEN_DONT_PARALLELIZE EIGEN_MPL2_ONLY)

set(PIPEWRIGHT_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize takes them")
if(PIPEWRIGHT_SANITIZE)
  target_compile_options(pipewright_options INTERFACE
    -fsanitize=${PIPEWRIGHT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(pipewright_options INTERFACE -fsanitize=${PIPEWRIGHT_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    # What others' headers do within themselves is theirs to check, and most of what UBSan looks at.
    target_compile_options(pipewright_options INTERFACE
      -fsanitize-ignorelist=${CMAKE_CURRENT_LIST_DIR}/ubsan_ignore.txt)
  endif()
endif()

option(PIPEWRIGHT_FUZZ "Build the fuzzers of tests/fuzz instead of the tests; needs clang" OFF)
if(PIPEWRIGHT_FUZZ)
  # Coverage tells libFuzzer which inputs lead to something new; checks that a container's use is
  # within its bounds tell what the sanitizers do not see.
  target_compile_options(pipewright_options INTERFACE -fsanitize=fuzzer-no-link)
  target_compile_definitions(pipewright_options INTERFACE _GLIBCXX_ASSERTIONS)
endif()
