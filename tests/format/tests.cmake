# The formatter: golden files, and every program of the repository, also with comments in odd places and with another layout.
add_test(NAME format COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/format_test.py --meldc $<TARGET_FILE:meldc>)
