# The Open Dynamics Engine: collisions of boxes.
from spack.package import *


class Ode(CMakePackage):
    """Open Dynamics Engine, a library for simulating rigid bodies."""

    homepage = "https://www.ode.org"
    url = "https://bitbucket.org/odedevs/ode/downloads/ode-0.16.2.tar.gz"
    license("BSD-3-Clause")
    version("0.16.2", sha256="b26aebdcb015e2d89720ef48e0cb2e8a3ca77915f89d853893e7cc861f810f22")

    depends_on("c", type="build")
    depends_on("cxx", type="build")

    def cmake_args(self):
        # Real numbers as in Debian's package: physics/collision asks for double precision when it is compiled.
        return [self.define("BUILD_SHARED_LIBS", True), self.define("ODE_DOUBLE_PRECISION", True), self.define("ODE_WITH_DEMOS", False),
                self.define("ODE_WITH_TESTS", False)]
