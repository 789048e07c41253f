# cmake -D SOURCE_DIR=... -P layering_test.cmake
# A file includes only headers of its own layer and of those below; the linker sees calls only, this
# sees headers too. The order is that of hpgo/CMakeLists.txt.
cmake_minimum_required(VERSION 3.22)

set(order ceres_costs hpgo/graph hpgo/state hpgo/hierarchy hpgo/chains hpgo/solve hpgo/schedule
          hpgo/update hpgo hpgo/ceres hpgo/live hpgo/io hpgo/evaluate hpgo/generate hpgo/report
          hpgo/adapters tools)
# Ceres is for the costs, the solvers and, as types alone, whoever hands them losses.
set(without_ceres hpgo/graph hpgo/state hpgo/hierarchy hpgo/chains hpgo/schedule hpgo/update
                  hpgo/live hpgo/io hpgo/generate hpgo/report)
set(may_build_problems hpgo/solve hpgo/ceres)

set(problems "")
set(checked 0)
file(GLOB_RECURSE files RELATIVE ${SOURCE_DIR} ${SOURCE_DIR}/ceres_costs/*.h
  ${SOURCE_DIR}/ceres_costs/*.cc ${SOURCE_DIR}/hpgo/*.h ${SOURCE_DIR}/hpgo/*.cc
  ${SOURCE_DIR}/tools/*.h ${SOURCE_DIR}/tools/*.cc)
foreach(file ${files})
  get_filename_component(layer ${file} DIRECTORY)
  list(FIND order ${layer} rank)
  if(rank EQUAL -1)
    string(APPEND problems "${file}: the folder ${layer} is no layer\n")
    continue()
  endif()
  math(EXPR checked "${checked} + 1")
  file(STRINGS ${SOURCE_DIR}/${file} includes REGEX "^ *#include")
  foreach(include ${includes})
    string(REGEX REPLACE "^ *#include *[\"<]([^\">]*)[\">].*" "\\1" header "${include}")
    get_filename_component(folder ${header} DIRECTORY)
    list(FIND order "${folder}" other)
    if(other GREATER rank)
      string(APPEND problems "${file}: includes ${header}, of a layer above\n")
    endif()
    if(folder STREQUAL "ceres" AND layer IN_LIST without_ceres)
      string(APPEND problems "${file}: includes ${header}; ${layer} does without Ceres\n")
    endif()
    if(header MATCHES "^ceres/(problem|solver|ceres)\\.h$" AND NOT layer IN_LIST may_build_problems)
      string(APPEND problems "${file}: includes ${header}; only ${may_build_problems} may\n")
    endif()
  endforeach()
endforeach()
if(checked LESS 20)
  message(FATAL_ERROR "only ${checked} files found in ${SOURCE_DIR}")
endif()
if(problems)
  message(FATAL_ERROR "${problems}")
endif()
message("${checked} files keep to the layers")
