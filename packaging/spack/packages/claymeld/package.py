# The recipe of Claymeld for Spack. The MPI is the one that the site has declared in packages.yaml: an external Open MPI.
#     spack repo add packaging/spack
#     spack install claymeld@main ^openmpi@4.1     from the repository that this recipe is in, its branch main
#     spack install claymeld@0.1.0 ^openmpi@4.1    in the folder of claymeld-0.1.0.tar.gz
import os

from spack.package import *


class Claymeld(CMakePackage):
    """A compiler and a runtime for Meld programs on ensembles of modular robots."""

    license("Apache-2.0")
    # The archive of a release is in the folder where Spack is called, or in a mirror of the site. docs/releasing.md says where its sum
    # goes.
    manual_download = True
    url = f"file://{os.getcwd()}/claymeld-0.1.0.tar.gz"
    # Named once more: without it Spack would take this version from the repository too.
    version("0.1.0", url=url)
    # The repository is four folders above that of this file.
    git = f"file://{os.path.abspath(os.path.join(os.path.dirname(__file__), *[os.pardir] * 4))}"
    version("main", branch="main")

    # Sticky: Spack leaves out neither to build less.
    variant("view", default=True, sticky=True, description="Build pictures, films, plots and the viewer")
    variant("models", default=True, sticky=True, description="Read meshes and configurations of VisibleSim")
    # As `scripts/build` does. Not Debug: xxHash 0.8.1 does not compile for AVX-512 without optimization.
    variant("build_type", default="RelWithDebInfo", values=("RelWithDebInfo", "Release"), description="CMake build type")
    generator("ninja")

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
    depends_on("eigen@3.4:3")
    depends_on("assimp@5:", when="+models")
    depends_on("tinyxml2", when="+models")
    depends_on("metis@5:")
    depends_on("sqlite@3:")
    depends_on("libedit")
    depends_on("embree@3", when="+view")
    depends_on("cairo+svg+png", when="+view")
    # These are beside this folder.
    depends_on("ode")
    depends_on("civetweb@1.15", when="+view")

    # The page of the viewer, which is part of meldsim, is made of these.
    resource(name="three", url="https://registry.npmjs.org/three/-/three-0.111.0.tgz", placement="three", expand=True,
             when="+view", sha256="c0f06a76cad7d725a8a21d11d1de145e1f574d68cb130ab2f153e0c1c289bf41")
    resource(name="esbuild", url="https://registry.npmjs.org/@esbuild/linux-x64/-/linux-x64-0.17.0.tgz", placement="esbuild",
             when="+view target=x86_64:", sha256="e170e436f83a6139826f6c6c01f98f08e0af29ea7adb3778ba9dd5dc4d6da8cd")
    resource(name="esbuild", url="https://registry.npmjs.org/@esbuild/linux-arm64/-/linux-arm64-0.17.0.tgz", placement="esbuild",
             when="+view target=aarch64:", sha256="9bda92d85337be3499f9cfce7dbbe3dfba123b03f93829a354d9b933cb742bdd")

    def cmake_args(self):
        # Spack takes away the folder that all files of an archive of npm are in.
        source = self.stage.source_path
        arguments = [
            self.define("CLAYMELD_PROGRAMS_ONLY", True),
            self.define("CLAYMELD_UNITY", True),
            self.define("CLAYMELD_LLVM_ROOT", self.spec["llvm"].prefix),
            self.define_from_variant("CLAYMELD_VIEWER", "view"),
            self.define_from_variant("CLAYMELD_MODELS", "models"),
        ]
        if self.spec.satisfies("~view"):
            return arguments
        return [
            *arguments,
            self.define("ESBUILD", join_path(source, "esbuild", "bin", "esbuild")),
            self.define("THREE_MODULE", join_path(source, "three", "build", "three.module.js")),
        ]

    def install(self, spec, prefix):
        with working_dir(self.build_directory):
            cmake("--install", ".", "--component", "claymeld")
            if spec.satisfies("+view"):
                cmake("--install", ".", "--component", "view")

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def check_install(self):
        program = join_path(self.prefix.share, "claymeld", "examples", "gradient.meld")
        Executable(self.prefix.bin.meldsim)("run", program, "--quiet", "--facts-out", "gradient.facts")
