# Runs small scenes under Oclgrind, which reports data races, accesses out of
# bounds and wrong calls of OpenCL. Its interpreter lacks what LLVM's inlining
# leaves behind, so kernels are built without optimisation.
#
#   PROGRAM  duet
#   SCENES   lua/scenes
set(oclgrind oclgrind --build-options -cl-opt-disable --data-races --check-api)
set(small --n 150 --set world=9 --repeat 1 --check)

# One device does all: Oclgrind stops where two run at once.
foreach(case
    "paper.lua --variant rows --share 1"
    "paper.lua --variant paper --share 1 --mode shared"
    "paper.lua --variant rows --share 1 --mode shared --set rotated=false"
    "paper2d.lua --variant rows --share 0"
    "paper2d.lua --variant paper --share 1")
  separate_arguments(arguments UNIX_COMMAND "${case}")
  execute_process(COMMAND ${oclgrind} ${PROGRAM} run ${SCENES}/${arguments} ${small}
    RESULT_VARIABLE status OUTPUT_VARIABLE out ERROR_VARIABLE err)
  if(NOT status EQUAL 0 OR NOT err STREQUAL "" OR NOT out MATCHES "as the plain C reference")
    message(FATAL_ERROR "${case}: ${status}\n${err}\n${out}")
  endif()
endforeach()
