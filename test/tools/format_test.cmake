# cmake -D SOURCE_DIR=... -D CLANG_FORMAT=... -P format_test.cmake
# Every source file is formatted as .clang-format says.
file(GLOB_RECURSE files RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/ceres_costs/*.h
  ${SOURCE_DIR}/ceres_costs/*.cc ${SOURCE_DIR}/hpgo/*.h ${SOURCE_DIR}/hpgo/*.cc
  ${SOURCE_DIR}/tools/*.h ${SOURCE_DIR}/tools/*.cc ${SOURCE_DIR}/test/*.h ${SOURCE_DIR}/test/*.cc)
execute_process(COMMAND ${CLANG_FORMAT} --dry-run -Werror ${files} WORKING_DIRECTORY ${SOURCE_DIR}
                RESULT_VARIABLE code ERROR_VARIABLE output)
if(NOT code EQUAL 0)
  message(FATAL_ERROR "${output}")
endif()
