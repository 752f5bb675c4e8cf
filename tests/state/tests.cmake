# Runs that are stopped and go on.
meld_test(test_state SOURCES ${CMAKE_CURRENT_LIST_DIR}/snapshot_test.cpp DEPENDS runtime/driver)
target_compile_definitions(test_state PRIVATE CLAYMELD_EXAMPLES="${CMAKE_SOURCE_DIR}/examples/meld"
                                              CLAYMELD_STATE_TESTS="${CMAKE_CURRENT_LIST_DIR}")
add_dependencies(test_state meldc)

add_test(NAME state_members COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/members_test.py ${CMAKE_SOURCE_DIR})
