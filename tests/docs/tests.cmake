# Every block of code in the documentation is run, and what the pages say it prints is compared.
# Some pages take longer than all others. Other tests run the same too (amoebots_*, cli_*, conditions_*, distributed_*, failures, fields_*,
# motion_*, networks, papers_*, pictures_*, python_*, study_* and program_shape_change), so these pages are a long test.
set(docs_test ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/docs_test.py --bin $<TARGET_FILE_DIR:meldc>)
set(long_pages
  algorithms amoebots coming_from commands connections extending faults fields graphs joints library motion moves networks older
  papers physics pictures python recordings robots runs scaling shapes study swarms teaching viewer worked_study worlds)
list(TRANSFORM long_pages REPLACE "(.+)" "${CMAKE_SOURCE_DIR}/docs/\\1.md")
add_test(NAME docs COMMAND ${docs_test} --without ${long_pages})
add_test(NAME docs_more COMMAND ${docs_test} ${long_pages})
# Its pages run beside each other, two at a time, and some examples are long: beside four other tests they would not end in time.
set_tests_properties(docs PROPERTIES TIMEOUT 600 PROCESSORS 2)
set_tests_properties(docs_more PROPERTIES TIMEOUT 1200 PROCESSORS 2 LABELS long)
# Options that commands name, also commands that are not run.
add_test(NAME docs_options COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/options_test.py --bin $<TARGET_FILE_DIR:meldc>)
# The numbers of formats and versions that pages and recipes say.
add_test(NAME docs_formats COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/formats_test.py)
