# Makes Oclgrind's simulator a platform beside those of the machine. It reports
# data races, accesses out of bounds and wrong calls of OpenCL. Its interpreter
# lacks what LLVM's inlining leaves behind, so it builds kernels without
# optimisation.
#
#   ICD      Oclgrind's driver; empty where there is none
#   FOLDER   where to list the drivers
if(NOT ICD)
  message("no oclgrind here")
  return()
endif()
file(REMOVE_RECURSE ${FOLDER})
file(GLOB drivers /etc/OpenCL/vendors/*.icd)
file(COPY ${drivers} DESTINATION ${FOLDER})
file(WRITE ${FOLDER}/oclgrind.icd "${ICD}\n")
set(ENV{OCL_ICD_VENDORS} ${FOLDER})
set(ENV{OCLGRIND_BUILD_OPTIONS} -cl-opt-disable)
set(ENV{OCLGRIND_DATA_RACES} 1)
set(ENV{OCLGRIND_CHECK_API} 1)
