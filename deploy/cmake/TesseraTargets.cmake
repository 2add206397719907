# One target a folder.

# tessera_library(NAME SOURCES... [DEPENDS targets...]): a static library of this folder. The include root is the
# top-level folder that it lies in (proto/, server/, worker/, client/).
function(tessera_library name)
  cmake_parse_arguments(arg "" "" "DEPENDS" ${ARGN})
  add_library(${name} STATIC ${arg_UNPARSED_ARGUMENTS})
  string(REGEX MATCH "^${CMAKE_SOURCE_DIR}/[a-z]+" root ${CMAKE_CURRENT_SOURCE_DIR})
  target_include_directories(${name} PUBLIC ${root})
  target_link_libraries(${name} PUBLIC ${arg_DEPENDS} PRIVATE tessera_options)
endfunction()

# tessera_test(NAME SOURCES... DEPENDS targets... [LABELS labels...] [TIMEOUT seconds]): a GoogleTest program, one ctest
# entry. The working directory is the source tree's root.
function(tessera_test name)
  cmake_parse_arguments(arg "" "TIMEOUT" "DEPENDS;LABELS" ${ARGN})
  add_executable(${name} ${arg_UNPARSED_ARGUMENTS})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR}/tests)
  target_link_libraries(${name} PRIVATE ${arg_DEPENDS} GTest::gmock GTest::gtest_main tessera_options)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  add_test(NAME ${name} COMMAND ${name} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 120)
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${arg_TIMEOUT} LABELS "${arg_LABELS}")
endfunction()
