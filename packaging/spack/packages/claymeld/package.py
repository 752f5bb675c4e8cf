# The recipe of Claymeld for Spack. The MPI is the one that the site has declared in packages.yaml: an external Open MPI.
#     spack repo add packaging/spack
#     spack install claymeld ^openmpi@4.1
# From a copy of the repository instead of an archive: spack develop --path $PWD claymeld@0.1.0
from spack.package import *


class Claymeld(CMakePackage):
    """A compiler and a runtime for Meld programs on ensembles of modular robots."""

    license("Apache-2.0")
    # The archive of a release is put into a mirror of the site; docs/releasing.md says where its sum goes.
    manual_download = True
    version("0.1.0")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("bison@3.8:", type="build")
    depends_on("flex", type="build")
    depends_on("openmpi")
    depends_on("hdf5@1.10:+mpi")
    # The compiler of modules, as libraries; LLVM's linker is one of its projects.
    depends_on("llvm@19+clang+lld+llvm_dylib")
    depends_on("zlib-api")
    depends_on("zstd")
    depends_on("fmt@9:")
    depends_on("cli11@2:")
    depends_on("nlohmann-json@3:")
    depends_on("tomlplusplus@3:")
    depends_on("tl-expected@1:")
    depends_on("random123")
    depends_on("xxhash")
    depends_on("eigen@3.4:")
    depends_on("assimp@5:")
    depends_on("tinyxml2")
    depends_on("metis@5:")
    depends_on("sqlite@3:")
    depends_on("libedit")
    # In this folder: Spack has none of them.
    depends_on("ode")
    depends_on("civetweb")
    depends_on("embree@3")
    depends_on("cairo+svg+png")

    # The page of the viewer, which is part of meldsim, is made of these.
    resource(name="three", url="https://registry.npmjs.org/three/-/three-0.111.0.tgz", placement="three", expand=True)
    resource(name="esbuild", url="https://registry.npmjs.org/@esbuild/linux-x64/-/linux-x64-0.17.0.tgz", placement="esbuild",
             when="target=x86_64:")
    resource(name="esbuild", url="https://registry.npmjs.org/@esbuild/linux-arm64/-/linux-arm64-0.17.0.tgz", placement="esbuild",
             when="target=aarch64:")

    def cmake_args(self):
        source = self.stage.source_path
        return [
            self.define("CLAYMELD_PROGRAMS_ONLY", True),
            self.define("CLAYMELD_UNITY", True),
            self.define("CLAYMELD_LLVM_ROOT", self.spec["llvm"].prefix),
            self.define("ESBUILD", join_path(source, "esbuild", "package", "bin", "esbuild")),
            self.define("THREE_MODULE", join_path(source, "three", "package", "build", "three.module.js")),
        ]

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_install(self):
        program = join_path(self.prefix.share, "claymeld", "examples", "gradient.meld")
        Executable(self.prefix.bin.meldsim)("run", program, "--quiet", "--facts-out", "gradient.facts")
