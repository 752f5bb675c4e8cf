// Instead of runtime/show/view/http.cpp in a program that is built without pictures and the viewer.
#include "runtime/show/library/view_library.h"
#include "runtime/show/library/without/left_out.h"
#include "runtime/show/view/http.h"

namespace meld::view {

using show::left_out;

struct Server::Page {};

Result<std::unique_ptr<Server>> Server::start(ServerOptions) { return tl::unexpected<Error>(show::need_view().error()); }
Server::~Server() = default;
std::string Server::link() const { left_out("a server"); }
std::optional<Arrived> Server::next(std::chrono::milliseconds) { left_out("a server"); }
void Server::answer(PageId, std::string, std::string) { left_out("a server"); }
void Server::push(const std::string&, const std::string&) { left_out("a server"); }
bool Server::is_open(PageId) { left_out("a server"); }

}  // namespace meld::view
