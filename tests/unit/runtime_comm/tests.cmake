# The semantic cases over real processes: one program, started by mpirun for each number of parts.
add_executable(test_runtime_comm_mpi ${CMAKE_CURRENT_LIST_DIR}/mpi/mpi_semantics.cpp ${CMAKE_CURRENT_LIST_DIR}/semantics.cpp)
target_link_libraries(test_runtime_comm_mpi PRIVATE runtime_comm)
add_dependencies(unit_tests test_runtime_comm_mpi)
# Open MPI never gives back all of its memory, so leaks are not looked for.
set(mpi_environment ASAN_OPTIONS=detect_leaks=0 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
                    OMPI_MCA_rmaps_base_oversubscribe=1)
foreach(parts 1 2 3 4)
  add_test(NAME test_runtime_comm_mpi_${parts}
           COMMAND ${MPIEXEC_EXECUTABLE} --bind-to none -n ${parts} $<TARGET_FILE:test_runtime_comm_mpi>)
  set_tests_properties(test_runtime_comm_mpi_${parts} PROPERTIES ENVIRONMENT "${mpi_environment}" TIMEOUT 120 PROCESSORS 2)
endforeach()
