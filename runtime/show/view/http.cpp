#include "runtime/show/view/http.h"

#include <fmt/format.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <exception>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "runtime/show/library/civetweb_calls.h"
#include "runtime/show/view/token.h"

namespace meld::view {

namespace {

// Each open page takes one of them for as long as it is open; the others are for requests, and for those who connect and say nothing.
constexpr const char* kThreads = "24";
static_assert(kMostPages == 12);
// Of a request, its headers included, which has no reason to be long.
constexpr const char* kMostRequest_bytes = "8192";
// Whoever says nothing, or does not read what it has asked for, has so long; an open page is asked so often whether it is there.
constexpr const char* kPatience_ms = "5000";
constexpr const char* kPing_ms = "10000";
constexpr const char* kWebSocket = "/ws";

// Everything is in the page itself, and no other page may read or link to it. {} is where WebSockets go.
constexpr std::string_view kHeaders =
    "Cache-Control: no-store\r\n"
    "X-Content-Type-Options: nosniff\r\n"
    "Referrer-Policy: no-referrer\r\n"
    "Cross-Origin-Opener-Policy: same-origin\r\n"
    "Cross-Origin-Resource-Policy: same-origin\r\n"
    "Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'self' ws://{}; base-uri 'none'; form-action 'none'; frame-ancestors ";
// Who may show the page in a frame. X-Frame-Options is for browsers that do not know the other; it has no word for this machine.
constexpr std::string_view kNobody = "'none'\r\nX-Frame-Options: DENY\r\n";
constexpr std::string_view kThisMachine = "http://localhost:* http://127.0.0.1:* https://localhost:* https://127.0.0.1:*\r\n";

std::string headers(std::string_view host, bool framed) {
    return fmt::format(fmt::runtime(kHeaders), host).append(framed ? kThisMachine : kNobody);
}

std::string_view text_or_none(const char* text) { return text == nullptr ? std::string_view() : std::string_view(text); }

// Whether a request names this machine, with whatever port: one that leads here through ssh may have any number. A page of somebody else
// whose name leads here (DNS rebinding) names that.
bool names_loopback(std::string_view host) {
    for (const std::string_view name : {"127.0.0.1", "localhost", "[::1]"}) {
        if (!host.starts_with(name)) continue;
        const std::string_view port = host.substr(name.size());
        const auto digit = [](char c) { return c >= '0' && c <= '9'; };
        return port.empty() || (port.size() > 1 && port.size() <= 6 && port[0] == ':' && std::ranges::all_of(port.substr(1), digit));
    }
    return false;
}

// Threads made while it lives leave signals to the thread that made them.
class WithoutSignals {
  public:
    WithoutSignals() {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~WithoutSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    WithoutSignals(const WithoutSignals&) = delete;
    WithoutSignals& operator=(const WithoutSignals&) = delete;

  private:
    sigset_t before_;
};

}  // namespace

struct Server::Page {
    PageId id = 0;
    mg_connection* connection = nullptr;
    Mailbox mailbox = {};
    std::string partial = {};  // Of a message that comes in several frames.
    std::thread writer = {};
};

// Static functions, since they are called from C. Nothing may be thrown out of them.
struct Server::Calls {
    static Server& server(const mg_connection* connection) { return *static_cast<Server*>(mg_get_user_data(mg_get_context(connection))); }

    // How the request names this server; its own name if that is not ours.
    static std::string host_of(const mg_connection* connection, const Server& server) {
        const std::string_view host = text_or_none(mg_get_header(connection, "Host"));
        return names_loopback(host) ? std::string(host) : server.host_;
    }

    // `cure` is for people; it may be empty.
    static void refuse(mg_connection* connection, Server& server, int status, const char* reason, const std::string& cure = {}) {
        const std::string body = fmt::format("{} {}\n{}{}", status, reason, cure, cure.empty() ? "" : "\n");
        mg_printf(connection, "HTTP/1.1 %d %s\r\n%sContent-Type: text/plain\r\nContent-Length: %d\r\nConnection: close\r\n\r\n%s", status,
                  reason, headers(server.host_, false).c_str(), static_cast<int>(body.size()), body.c_str());
    }

    // What is wrong with a request, before anything is looked for.
    struct Wrong {
        int status = 0;  // 0: nothing.
        const char* reason = "";
        std::string cure = {};
    };
    static Wrong wrong_with(const mg_connection* connection, const Server& server, bool socket) {
        const mg_request_info& request = *mg_get_request_info(connection);
        const std::string_view host = text_or_none(mg_get_header(connection, "Host"));
        const std::string_view origin = text_or_none(mg_get_header(connection, "Origin"));
        const auto forbidden = [](std::string cure) { return Wrong{403, "Forbidden", std::move(cure)}; };
        if (!names_loopback(host))
            return forbidden(
                fmt::format("The viewer answers only where it is called localhost or 127.0.0.1, with any port. From another "
                            "machine, lead a port here by `ssh -L 8080:127.0.0.1:{} HOST`, and open the link that the viewer has "
                            "printed with localhost:8080 in the place of {}.",
                            server.port_, server.host_));
        // Every browser says where a WebSocket was opened from. Of the page itself many say nothing.
        if ((socket || !origin.empty()) && origin != fmt::format("http://{}", host))
            return forbidden("The page of another server may not ask this one.");
        const std::string_view query = text_or_none(request.query_string);
        constexpr std::string_view kName = "token=";
        if (!query.starts_with(kName) || !same_secret(server.token_, query.substr(kName.size())))
            return forbidden("The link has no secret, or that of a viewer that has ended. Open the link that this one has printed.");
        if (text_or_none(request.request_method) != "GET") return {405, "Method Not Allowed"};
        // As it was written: what a path leads back to is no other way to write it.
        const std::string_view path = text_or_none(request.local_uri_raw);
        if (path == (socket ? kWebSocket : "/")) return {};
        return {404, "Not Found"};
    }

    static int begin(mg_connection* connection) {
        try {
            Server& it = server(connection);
            const bool socket = mg_get_header(connection, "Upgrade") != nullptr;
            if (const Wrong wrong = wrong_with(connection, it, socket); wrong.status != 0) {
                refuse(connection, it, wrong.status, wrong.reason, wrong.cure);
                return wrong.status;
            }
            if (socket) {
                bool full = false;
                {
                    const std::lock_guard lock(it.mutex_);
                    full = it.pages_.size() >= kMostPages || it.ending_;
                }
                if (!full) return 0;  // civetweb goes on, with connect().
                refuse(connection, it, 503, "Too many pages are open");
                return 503;
            }
            mg_printf(connection,
                      "HTTP/1.1 200 OK\r\n%sContent-Type: text/html; charset=utf-8\r\nContent-Length: %zu\r\nConnection: close\r\n\r\n",
                      headers(host_of(connection, it), it.options_.framed).c_str(), it.options_.page.size());
            mg_write(connection, it.options_.page.data(), it.options_.page.size());
            return 200;
        } catch (const std::exception&) {
            return 500;
        }
    }

    // What civetweb itself refuses.
    static int error(mg_connection* connection, int status, const char*) {
        try {
            refuse(connection, server(connection), status, "Refused");
        } catch (const std::exception&) {
        }
        return 0;
    }

    static int connect(const mg_connection* connection, void*) {
        try {
            Server& it = server(connection);
            const std::lock_guard lock(it.mutex_);
            // Others may have come since begin().
            if (it.pages_.size() >= kMostPages || it.ending_) return 1;
            auto page = std::make_shared<Page>();
            page->id = ++it.last_page_;
            mg_set_user_connection_data(connection, page.get());
            it.pages_.emplace(page->id, std::move(page));
            return 0;
        } catch (const std::exception&) {
            return 1;
        }
    }

    static void ready(mg_connection* connection, void*) {
        auto* const page = static_cast<Page*>(mg_get_user_connection_data(connection));
        page->connection = connection;
        try {
            page->writer = std::thread(write, std::ref(server(connection)), page);
        } catch (const std::exception&) {
            page->mailbox.close();
        }
    }

    static void write(Server& server, Page* page) {
        while (auto sent = page->mailbox.next_to_write()) {
            server.ring();
            const auto put = [&](int kind, const std::string& bytes) {
                return mg_websocket_write(page->connection, kind, bytes.data(), bytes.size()) > 0;
            };
            const bool written =
                put(MG_WEBSOCKET_OPCODE_TEXT, sent->text) && (sent->binary.empty() || put(MG_WEBSOCKET_OPCODE_BINARY, sent->binary));
            if (!written) page->mailbox.close();
        }
    }

    // Returns whether the connection stays.
    static int data(mg_connection* connection, int bits, char* bytes, std::size_t count, void*) {
        try {
            auto* const page = static_cast<Page*>(mg_get_user_connection_data(connection));
            return receive(server(connection), *page, static_cast<unsigned>(bits), {bytes, count}) ? 1 : 0;
        } catch (const std::exception&) {
            return 0;
        }
    }

    static bool receive(Server& server, Page& page, unsigned bits, std::string_view bytes) {
        constexpr unsigned kFinal = 0x80, kReserved = 0x70, kOpcode = 0x0f;
        const unsigned opcode = bits & kOpcode;
        if (opcode == MG_WEBSOCKET_OPCODE_PING || opcode == MG_WEBSOCKET_OPCODE_PONG) return true;
        const bool begins = opcode == MG_WEBSOCKET_OPCODE_TEXT, goes_on = opcode == MG_WEBSOCKET_OPCODE_CONTINUATION;
        if ((bits & kReserved) != 0 || (!begins && !goes_on) || begins != page.partial.empty()) return false;
        if (bytes.empty() || page.partial.size() + bytes.size() > kMostMessage_bytes) return false;
        page.partial += bytes;
        if ((bits & kFinal) == 0) return true;
        std::string text = std::exchange(page.partial, {});
        if (is_interrupt(text)) {
            server.interrupted_ = server.arrived_.load();
            return true;
        }
        const std::uint64_t number = ++server.arrived_;
        if (!page.mailbox.put({number, std::move(text)})) return false;
        server.ring();
        return true;
    }

    // The one request that does not wait for its turn.
    static bool is_interrupt(const std::string& text) {
        if (text.size() > 200 || text.find("interrupt") == std::string::npos) return false;
        const auto json = nlohmann::json::parse(text, nullptr, false);
        return json.is_object() && json.contains("do") && json["do"] == "interrupt";
    }

    static void close(const mg_connection* connection, void*) {
        auto* const page = static_cast<Page*>(mg_get_user_connection_data(connection));
        if (page == nullptr) return;
        page->mailbox.close();
        if (page->writer.joinable()) page->writer.join();
        Server& it = server(connection);
        {
            const std::lock_guard lock(it.mutex_);
            it.pages_.erase(page->id);
        }
        it.ring();
    }
};

void Server::ring() {
    {
        const std::lock_guard lock(mutex_);
        ++rings_;
    }
    bell_.notify_one();
}

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
    std::unique_ptr<Server> server(new Server(std::move(options)));
    Result<std::string> token = make_token();
    if (!token) return tl::unexpected<Error>(token.error());
    server->token_ = std::move(*token);
    if (auto listening = server->listen(); !listening) return tl::unexpected<Error>(listening.error());
    return server;
}

Result<void> Server::listen() {
    const WithoutSignals left_to_us;
    mg_init_library(0);
    const std::string address = fmt::format("127.0.0.1:{}", options_.port);
    const std::array<const char*, 27> how = {"listening_ports",
                                             address.c_str(),
                                             "num_threads",
                                             kThreads,
                                             "connection_queue",
                                             "64",
                                             "listen_backlog",
                                             "64",
                                             "max_request_size",
                                             kMostRequest_bytes,
                                             "request_timeout_ms",
                                             kPatience_ms,
                                             "websocket_timeout_ms",
                                             kPing_ms,
                                             "enable_websocket_ping_pong",
                                             "yes",
                                             "enable_keep_alive",
                                             "no",
                                             "enable_directory_listing",
                                             "no",
                                             "enable_auth_domain_check",
                                             "no",
                                             "decode_url",
                                             "no",
                                             "tcp_nodelay",
                                             "1",
                                             nullptr};
    mg_callbacks calls{};
    calls.begin_request = Calls::begin;
    calls.http_error = Calls::error;
    calls.log_message = [](const mg_connection*, const char*) { return 1; };
    context_ = mg_start(&calls, this, const_cast<const char**>(how.data()));
    if (context_ == nullptr)
        return fail(fmt::format("cannot listen at {}", address),
                    options_.port == 0 ? "" : "Another program may have this port: choose another --port, or none");
    mg_server_port found{};
    if (mg_get_server_ports(context_, 1, &found) < 1) return fail("the server has no port", "", ExitCode::OurBug);
    port_ = found.port;
    host_ = fmt::format("127.0.0.1:{}", port_);
    mg_set_websocket_handler(context_, kWebSocket, Calls::connect, Calls::ready, Calls::data, Calls::close, nullptr);
    return {};
}

Server::~Server() {
    if (context_ != nullptr) {
        {
            const std::lock_guard lock(mutex_);
            ending_ = true;
            // Those who read their connections wait for nobody.
            for (auto& [id, page] : pages_) page->mailbox.close();
        }
        mg_stop(context_);
    }
    mg_exit_library();
}

std::string Server::link() const { return fmt::format("http://{}/?token={}", host_, token_); }

// Of the page that comes after the one that had the last turn.
std::optional<Arrived> Server::take() {
    const auto try_page = [&](Page& page) -> std::optional<Arrived> {
        std::optional<Mailbox::Request> request = page.mailbox.take();
        if (!request) return std::nullopt;
        last_served_ = page.id;
        return Arrived{.page = page.id, .number = request->number, .text = std::move(request->text)};
    };
    const auto next = pages_.upper_bound(last_served_);
    for (auto at = next; at != pages_.end(); ++at)
        if (auto found = try_page(*at->second)) return found;
    for (auto at = pages_.begin(); at != next; ++at)
        if (auto found = try_page(*at->second)) return found;
    return std::nullopt;
}

std::optional<Arrived> Server::next(std::chrono::milliseconds patience) {
    const auto until = std::chrono::steady_clock::now() + patience;
    std::unique_lock lock(mutex_);
    while (true) {
        if (auto found = take()) return found;
        const std::uint64_t seen = rings_;
        if (!bell_.wait_until(lock, until, [&] { return rings_ != seen; })) return std::nullopt;
    }
}

void Server::answer(PageId page, std::string text, std::string binary) {
    const std::lock_guard lock(mutex_);
    if (const auto at = pages_.find(page); at != pages_.end()) at->second->mailbox.send({"", std::move(text), std::move(binary)});
}

void Server::push(const std::string& kind, const std::string& text) {
    const std::lock_guard lock(mutex_);
    for (auto& [id, page] : pages_) page->mailbox.send({kind, text, {}});
}

bool Server::is_open(PageId page) {
    const std::lock_guard lock(mutex_);
    return pages_.contains(page);
}

}  // namespace meld::view
