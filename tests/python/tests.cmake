# The Python package: that it is whole and typed; its layers; runs and sweeps; recordings; cells of notebooks.
foreach(file package layers run recording notebook)
  add_test(NAME python_${file} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/${file}_test.py --meldsim $<TARGET_FILE:meldsim>)
  set_tests_properties(python_${file} PROPERTIES ENVIRONMENT PYTHONPATH=${CMAKE_SOURCE_DIR}/python TIMEOUT 120)
endforeach()
