# Every outside library the project uses, all Debian packages (scripts/install lists them). packaging/ has the same for other systems.

find_package(Threads REQUIRED)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS CXX)
find_package(BISON 3.8 REQUIRED)
find_package(FLEX REQUIRED)
find_package(tomlplusplus REQUIRED)

add_library(meld_xxhash INTERFACE)
target_compile_definitions(meld_xxhash INTERFACE XXH_INLINE_ALL)

# Only runtime/comm sees MPI. The C++ bindings of MPI-2 are long gone and their headers warn.
add_library(meld_mpi INTERFACE)
target_link_libraries(meld_mpi INTERFACE MPI::MPI_CXX)
target_compile_definitions(meld_mpi INTERFACE OMPI_SKIP_MPICXX)

# The one of this MPI, which Debian has beside others; elsewhere there is one.
pkg_search_module(HDF5 REQUIRED IMPORTED_TARGET hdf5-openmpi hdf5)
add_library(meld_hdf5 INTERFACE)
target_link_libraries(meld_hdf5 INTERFACE PkgConfig::HDF5)

# Only physics sees ODE.
pkg_check_modules(ODE REQUIRED IMPORTED_TARGET ode)
add_library(meld_ode INTERFACE)
target_link_libraries(meld_ode INTERFACE PkgConfig::ODE)

# Vectors and small matrices.
find_package(Eigen3 REQUIRED NO_MODULE)
add_library(meld_eigen INTERFACE)
target_link_libraries(meld_eigen INTERFACE Eigen3::Eigen)

# Only runtime/show sees Embree and Cairo, rays for pictures and what is written over them, and civetweb, the server of the viewer.
# Only a plug-in is linked with them. Debian's package of civetweb for CMake asks for more than the library.
add_library(meld_view_headers INTERFACE)
if(CLAYMELD_VIEWER)
  find_package(embree 3 REQUIRED)
  pkg_check_modules(CAIRO REQUIRED IMPORTED_TARGET cairo)
  find_path(CIVETWEB_INCLUDE_DIR civetweb.h REQUIRED)
  find_library(CIVETWEB_LIBRARY civetweb REQUIRED)
  target_include_directories(meld_view_headers SYSTEM INTERFACE ${CIVETWEB_INCLUDE_DIR} ${CAIRO_INCLUDE_DIRS}
    $<TARGET_PROPERTY:embree,INTERFACE_INCLUDE_DIRECTORIES>)
  add_library(meld_view_libraries INTERFACE)
  target_link_libraries(meld_view_libraries INTERFACE meld_view_headers embree PkgConfig::CAIRO ${CIVETWEB_LIBRARY})
else()
  # In the place of the library that has them.
  add_library(meld_view INTERFACE)
endif()

# Runs in pages are compressed as browsers read it.
find_package(ZLIB REQUIRED)

# Only runtime/world/model sees the Open Asset Import Library, which reads files with meshes, and TinyXML: configurations of VisibleSim.
add_library(meld_assimp INTERFACE)
add_library(meld_tinyxml INTERFACE)
if(CLAYMELD_MODELS)
  pkg_check_modules(ASSIMP REQUIRED IMPORTED_TARGET assimp)
  target_link_libraries(meld_assimp INTERFACE PkgConfig::ASSIMP)
  pkg_check_modules(TINYXML REQUIRED IMPORTED_TARGET tinyxml2)
  target_link_libraries(meld_tinyxml INTERFACE PkgConfig::TINYXML)
endif()

# Only runtime/world/graph sees METIS: who owns which node of a graph.
find_path(METIS_INCLUDE_DIR metis.h REQUIRED)
find_library(METIS_LIBRARY metis REQUIRED)
add_library(meld_metis INTERFACE)
target_include_directories(meld_metis SYSTEM INTERFACE ${METIS_INCLUDE_DIR})
target_link_libraries(meld_metis INTERFACE ${METIS_LIBRARY})

# Only runtime/driver/study sees SQLite: the results of a sweep as a file.
pkg_check_modules(SQLITE REQUIRED IMPORTED_TARGET sqlite3)
add_library(meld_sqlite INTERFACE)
target_link_libraries(meld_sqlite INTERFACE PkgConfig::SQLITE)

# Only runtime/ask/debug sees libedit: lines that are typed at its prompt.
pkg_check_modules(EDIT REQUIRED IMPORTED_TARGET libedit)
add_library(meld_edit INTERFACE)
target_link_libraries(meld_edit INTERFACE PkgConfig::EDIT)

# Clang and LLVM come as one shared library each, LLVM's linker as two static ones; their headers are not ours to be warned
# about. Their own CMake packages would ask for a dozen further packages that nobody here needs.
set(CLAYMELD_LLVM_ROOT /usr/lib/llvm-19 CACHE PATH "Where LLVM 19 is installed")
find_path(LLVM_INCLUDE_DIR llvm/Config/llvm-config.h HINTS ${CLAYMELD_LLVM_ROOT}/include REQUIRED NO_DEFAULT_PATH)
find_library(LLVM_LIBRARY NAMES LLVM LLVM-19 HINTS ${CLAYMELD_LLVM_ROOT}/lib REQUIRED NO_DEFAULT_PATH)
find_library(CLANG_LIBRARY NAMES clang-cpp libclang-cpp.so.19.1 HINTS ${CLAYMELD_LLVM_ROOT}/lib REQUIRED NO_DEFAULT_PATH)
find_library(LLD_ELF_LIBRARY lldELF HINTS ${CLAYMELD_LLVM_ROOT}/lib REQUIRED NO_DEFAULT_PATH)
find_library(LLD_COMMON_LIBRARY lldCommon HINTS ${CLAYMELD_LLVM_ROOT}/lib REQUIRED NO_DEFAULT_PATH)
file(STRINGS ${LLVM_INCLUDE_DIR}/llvm/Config/llvm-config.h llvm_version REGEX "define LLVM_VERSION_STRING")
string(REGEX MATCH "[0-9.]+" llvm_version "${llvm_version}")
add_library(meld_clang INTERFACE)
target_include_directories(meld_clang SYSTEM INTERFACE ${LLVM_INCLUDE_DIR})
target_link_libraries(meld_clang INTERFACE ${LLD_ELF_LIBRARY} ${LLD_COMMON_LIBRARY} ${CLANG_LIBRARY} ${LLVM_LIBRARY} z zstd)
add_library(meld_lsp_protocol INTERFACE)
if(NOT CLAYMELD_PROGRAMS_ONLY)
  find_package(GTest REQUIRED)
  # The protocol of language servers, from MLIR: a static library over LLVM's JSON. Only compiler/lsp sees it.
  find_path(MLIR_INCLUDE_DIR mlir/Tools/lsp-server-support/Transport.h HINTS ${CLAYMELD_LLVM_ROOT}/include REQUIRED NO_DEFAULT_PATH)
  find_library(MLIR_LSP_LIBRARY MLIRLspServerSupportLib HINTS ${CLAYMELD_LLVM_ROOT}/lib REQUIRED NO_DEFAULT_PATH)
  target_include_directories(meld_lsp_protocol SYSTEM INTERFACE ${MLIR_INCLUDE_DIR})
  target_link_libraries(meld_lsp_protocol INTERFACE ${MLIR_LSP_LIBRARY} ${LLVM_LIBRARY})
endif()
add_library(meld_clang_version INTERFACE)
target_compile_definitions(meld_clang_version INTERFACE CLAYMELD_LLVM_VERSION="${llvm_version}")
