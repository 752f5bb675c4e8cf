# The server of the viewer. Spack has a civetweb from 1.0 on, which brings Lua and OpenSSL; this one needs neither.
from spack.package import *


class Civetweb(CMakePackage):
    """A web server as a small library, with WebSockets."""

    homepage = "https://github.com/civetweb/civetweb"
    url = "https://github.com/civetweb/civetweb/archive/refs/tags/v1.15.tar.gz"
    license("MIT")
    version("1.15", sha256="90a533422944ab327a4fbb9969f0845d0dba05354f9cacce3a5005fa59f593b9")

    depends_on("c", type="build")
    depends_on("cxx", type="build")

    def cmake_args(self):
        return [self.define("BUILD_SHARED_LIBS", True), self.define("CIVETWEB_BUILD_TESTING", False),
                self.define("CIVETWEB_ENABLE_WEBSOCKETS", True), self.define("CIVETWEB_ENABLE_SSL", False),
                self.define("CIVETWEB_ENABLE_SERVER_EXECUTABLE", False)]
