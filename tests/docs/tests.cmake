# Every block of code in the documentation is run, and what the pages say it prints is compared.
add_test(NAME docs COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/docs_test.py --bin $<TARGET_FILE_DIR:meldc>)
