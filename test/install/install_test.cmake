# cmake -D BUILD_DIR=... -D WORK_DIR=... ... -P install_test.cmake
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${code}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

set(prefix ${WORK_DIR}/prefix)
file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})

# What is installed must not point back at where it was built.
file(GLOB_RECURSE configs ${prefix}/*.cmake)
foreach(config ${configs})
  file(READ ${config} text)
  foreach(path ${SOURCE_DIR} ${BUILD_DIR})
    string(FIND "${text}" "${path}/" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${config} names ${path}")
    endif()
  endforeach()
endforeach()

# Every header can be included from the prefix: what it includes is installed as well.
file(GLOB_RECURSE headers RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/hpgo/*.h ${SOURCE_DIR}/ceres_costs/*.h)
set(includes "")
foreach(header ${headers})
  string(APPEND includes "#include \"${header}\"\n")
endforeach()
file(WRITE ${WORK_DIR}/all_headers.cc "${includes}int main() { return 0; }\n")

set(flags "")
if(SANITIZE)
  # As in the top CMakeLists.txt.
  set(flags "-fsanitize=address,undefined -DEIGEN_MALLOC_ALREADY_ALIGNED=1")
endif()
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/build -G ${GENERATOR}
    -D CMAKE_PREFIX_PATH=${prefix} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
    -D CMAKE_BUILD_TYPE=${BUILD_TYPE} "-DCMAKE_CXX_FLAGS=${flags}"
    -D ALL_HEADERS=${WORK_DIR}/all_headers.cc)
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
run(${WORK_DIR}/build/one_layer)
run(${WORK_DIR}/build/consumer)
if(NOT output MATCHES "chi2 after: 0\\.0000")
  message(FATAL_ERROR "the consumer printed:\n${output}")
endif()

run(${prefix}/bin/hpgo --version)
if(NOT output STREQUAL "hpgo ${VERSION}\n")
  message(FATAL_ERROR "the installed program printed:\n${output}")
endif()
