# It turns the checks of the kernel on, which no other test is to be compiled with.
set_source_files_properties(${CMAKE_CURRENT_LIST_DIR}/check_test.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
