# pipewright_parse_once(TARGET ...): they take the headers of headers.cmake that PIPEWRIGHT_HEADERS
# names for their room.
function(pipewright_parse_once)
  if(TARGET "${PIPEWRIGHT_HEADERS}")
    foreach(target ${ARGN})
      target_precompile_headers(${target} REUSE_FROM ${PIPEWRIGHT_HEADERS})
    endforeach()
  endif()
endfunction()

# pipewright_module(NAME SOURCES ... DEPENDS ...): the static library of one folder.
# A folder of headers alone becomes an interface library.
function(pipewright_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  if(ARG_SOURCES)
    add_library(${name} STATIC ${ARG_SOURCES})
    target_link_libraries(${name} PUBLIC ${ARG_DEPENDS} PRIVATE pipewright_options)
    target_include_directories(${name} PUBLIC ${PROJECT_SOURCE_DIR})
    target_compile_definitions(${name} PUBLIC EIGEN_DONT_PARALLELIZE)
    pipewright_parse_once(${name})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE ${ARG_DEPENDS})
    target_include_directories(${name} INTERFACE ${PROJECT_SOURCE_DIR})
  endif()
endfunction()

# pipewright_test(NAME SOURCES ... DEPENDS ...): one GoogleTest binary for one folder of tests/.
function(pipewright_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS} GTest::gtest_main pipewright_options)
  add_test(NAME ${name} COMMAND ${name})
  set(PIPEWRIGHT_HEADERS parsed_test_headers)
  pipewright_parse_once(${name})
endfunction()

# pipewright_runs(TEST PROGRAM NAME): the test runs the program, whose path it is told as the macro
# NAME, and the caller as the variable. Where this machine cannot run the program, that is a script
# which has it emulated.
function(pipewright_runs test program name)
  set(path "$<TARGET_FILE:${program}>")
  if(CMAKE_CROSSCOMPILING_EMULATOR)
    list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " emulator)
    set(script ${CMAKE_CURRENT_BINARY_DIR}/emulated/${program})
    file(GENERATE OUTPUT ${script} CONTENT "#!/bin/sh\nexec ${emulator} ${path} \"$@\"\n"
      FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
    set(path ${script})
  endif()
  add_dependencies(${test} ${program})
  target_compile_definitions(${test} PRIVATE ${name}="${path}")
  set(${name} ${path} PARENT_SCOPE)
endfunction()
