# The formatter: golden files, and every program of the repository, also with comments in odd places and with another layout.
set(format_test ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/format_test.py --meldc $<TARGET_FILE:meldc>)
add_test(NAME format COMMAND ${format_test} Golden Command)
add_test(NAME format_programs COMMAND ${format_test} Programs)
