# Colours: the TextMate grammar of the VS Code extension and the Pygments lexer, against the compiler's own tokens.
add_test(NAME editors COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/editors_test.py --meldc $<TARGET_FILE:meldc>)
# The extension of VS Code as a file.
add_test(NAME editors_vsix COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/vsix_test.py)
