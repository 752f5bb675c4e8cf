# Random programs against the reference evaluator.
file(GLOB reference_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.cpp)
set(reference_shared ${CMAKE_CURRENT_SOURCE_DIR}/retraction/case.cpp ${CMAKE_CURRENT_SOURCE_DIR}/retraction/changes.cpp)
add_executable(test_random ${reference_sources} ${reference_shared})
target_link_libraries(test_random PRIVATE compiler_driver runtime_record runtime_module)
add_test(NAME random_programs COMMAND test_random --seeds 150 --out ${CMAKE_BINARY_DIR}/random_failures)
set_tests_properties(random_programs PROPERTIES TIMEOUT 600)
