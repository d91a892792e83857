# Makes the target openvdb_library where OpenVDB is installed. The plug-ins around OpenVDB, tests, seeds, samples and
# benchmarks link it; the program itself does not. Does not use Debian's FindOpenVDB: it asks for Imath's CMake package,
# which names a Python library that is not installed with Imath.
if(TARGET openvdb_library)
  return()
endif()
find_library(OPENVDB_LIBRARY openvdb)
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h)
if(OPENVDB_LIBRARY AND OPENVDB_INCLUDE_DIR)
  find_package(TBB REQUIRED)
  add_library(openvdb_library INTERFACE)
  target_link_libraries(openvdb_library INTERFACE ${OPENVDB_LIBRARY} TBB::tbb)
  target_include_directories(openvdb_library SYSTEM INTERFACE ${OPENVDB_INCLUDE_DIR})
elseif(ISOEXTRACT_TESTS OR ISOEXTRACT_FUZZ OR ISOEXTRACT_BENCHMARKS)
  message(FATAL_ERROR "Tests and benchmarks use OpenVDB: `scripts/setup.sh test bench` installs it")
endif()
