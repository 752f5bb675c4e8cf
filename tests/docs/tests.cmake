# Every block of code in the documentation is run, and what the pages say it prints is compared.
add_test(NAME docs COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/docs_test.py --bin $<TARGET_FILE_DIR:meldc>)
# Its pages run beside each other, and some examples are long: beside four other tests they would not end in time.
set_tests_properties(docs PROPERTIES PROCESSORS 2)
# The numbers of formats and versions that pages and recipes say.
add_test(NAME docs_formats COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/formats_test.py)
