# SPDX-License-Identifier: MIT
# Commands that must succeed. run leaves what a command prints in out, and run_says compares it.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV}: ${status}\n${out}")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()

function(run_says expected)
  run(${ARGN})
  if(NOT out MATCHES "${expected}")
    message(FATAL_ERROR "${ARGN} says '${out}', not '${expected}'")
  endif()
  set(out "${out}" PARENT_SCOPE)
endfunction()
