# Runs in the virtual cluster, processes of which are killed and brought back. CLAYMELD_CLUSTER_SEEDS says how many for each program.
meld_test(test_cluster SOURCES ${CMAKE_CURRENT_LIST_DIR}/cluster_test.cpp DEPENDS runtime/driver)
target_compile_definitions(test_cluster PRIVATE CLAYMELD_EXAMPLES="${CMAKE_SOURCE_DIR}/examples/meld"
                                                CLAYMELD_STATE_TESTS="${CMAKE_SOURCE_DIR}/tests/state")
add_dependencies(test_cluster meldc)

add_test(NAME cluster_campaign COMMAND ${CMAKE_COMMAND} -E env CLAYMELD_CLUSTER_SEEDS=60 $<TARGET_FILE:test_cluster>)
set_tests_properties(cluster_campaign PROPERTIES LABELS campaign TIMEOUT 1800)

# Two hosts, really: namespaces of this machine, where it lets root make them.
add_test(NAME cluster_two_hosts COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/two_hosts_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(cluster_two_hosts PROPERTIES TIMEOUT 400 PROCESSORS 2)
