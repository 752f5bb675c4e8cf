# What `cmake --install` leaves under a prefix; and, in the campaign where the machine allows it, the Debian packages in a clean root.
add_test(NAME install COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/install_test.py --build ${CMAKE_BINARY_DIR} -v)
set_tests_properties(install PROPERTIES TIMEOUT 300)
# What is left of meldsim without its optional parts.
add_test(NAME install_parts COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/parts_test.py --build ${CMAKE_BINARY_DIR} -v)
set_tests_properties(install_parts PROPERTIES TIMEOUT 900)
# The Debian packages: what is in which, and what each needs.
add_test(NAME install_packages COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/packages_test.py --build ${CMAKE_BINARY_DIR} -v)
set_tests_properties(install_packages PROPERTIES TIMEOUT 600)
# The wheel with the programs in it, installed into an empty environment of Python.
add_test(NAME install_wheel COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/wheel_test.py --build ${CMAKE_BINARY_DIR} -v)
set_tests_properties(install_wheel PROPERTIES TIMEOUT 300)
# The recipes for other systems, as far as they can be read without them.
add_test(NAME install_recipes COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/recipes_test.py)
# The same in the hands of Spack, EasyBuild and rattler-build, where these are.
add_test(NAME install_recipes_read COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/built_test.py --build ${CMAKE_BINARY_DIR})
set_tests_properties(install_recipes_read PROPERTIES TIMEOUT 7200)
find_program(DEBOOTSTRAP debootstrap PATHS /usr/sbin)
execute_process(COMMAND id -u OUTPUT_VARIABLE user_id OUTPUT_STRIP_TRAILING_WHITESPACE)
if(DEBOOTSTRAP AND user_id STREQUAL "0")
  add_test(NAME install_package COMMAND ${CMAKE_CPACK_COMMAND} -G DEB)
  set_tests_properties(install_package PROPERTIES WORKING_DIRECTORY ${CMAKE_BINARY_DIR} LABELS campaign FIXTURES_SETUP package)
  add_test(NAME install_make_wheel COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_SOURCE_DIR}/packaging/wheel/make.py --build ${CMAKE_BINARY_DIR}
    --out ${CMAKE_BINARY_DIR})
  set_tests_properties(install_make_wheel PROPERTIES LABELS campaign FIXTURES_SETUP package)
  add_test(NAME install_clean_root COMMAND ${CMAKE_CURRENT_LIST_DIR}/clean_root ${CMAKE_BINARY_DIR}/${CLAYMELD_PACKAGE_NAME}.deb
    ${CMAKE_BINARY_DIR}/claymeld-view_${PROJECT_VERSION}.deb
    ${CMAKE_BINARY_DIR}/claymeld-${PROJECT_VERSION}-py3-none-linux_${CMAKE_HOST_SYSTEM_PROCESSOR}.whl)
  set_tests_properties(install_clean_root PROPERTIES LABELS campaign FIXTURES_REQUIRED package TIMEOUT 1800)
endif()
