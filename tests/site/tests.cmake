# The documentation as a site, with the runs of its examples in it.
add_test(NAME site COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/site_test.py --build ${CMAKE_BINARY_DIR} -v)
set_tests_properties(site PROPERTIES TIMEOUT 600 PROCESSORS 2)
