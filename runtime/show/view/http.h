// The server of a viewer: one page over HTTP, and messages with the pages that are open over WebSockets. The only use of civetweb.
//
// It listens on the loopback interface only. Nothing is read from the disk: there is one path, and its content is in memory. Every request
// must name this server as its host, so no other name leads here; must know the token; and a WebSocket must have been opened by a page of
// this server. The threads of the server only pass messages on: whoever owns the run takes them one by one, on its own thread.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/show/view/mailbox.h"

struct mg_connection;
struct mg_context;

namespace meld::view {

// More are turned away.
inline constexpr std::size_t kMostPages = 12;
inline constexpr std::size_t kMostMessage_bytes = std::size_t{1} << 20;

using PageId = std::uint64_t;

struct ServerOptions {
    int port = 0;           // 0: one that is free.
    std::string page = {};  // What is served: HTML.
    bool framed = false;    // Pages of other servers of this machine may show it in a frame, as notebooks do.
};

struct Arrived {
    PageId page = 0;
    std::uint64_t number = 0;
    std::string text = {};
};

// All calls are of the thread that owns the run, except for those that say otherwise.
class Server {
  public:
    // Errors: the port is taken; the system has no random numbers.
    static Result<std::unique_ptr<Server>> start(ServerOptions options);
    // Ends all connections.
    ~Server();
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    int port() const { return port_; }
    // With the token.
    std::string link() const;

    // The next request of those pages that read their answers; each has its turn. Waits no longer than this.
    std::optional<Arrived> next(std::chrono::milliseconds patience);
    // To a page that may be gone, and then nothing happens.
    void answer(PageId page, std::string text, std::string binary = {});
    // To all pages. One that has not read the last news of this kind gets only these.
    void push(const std::string& kind, const std::string& text);
    bool is_open(PageId page);
    // Whether a page has asked for the end of this request, which is being carried out.
    bool interrupted(std::uint64_t number) const { return number <= interrupted_.load(); }

  private:
    struct Page;
    struct Calls;  // What civetweb calls, on its threads.
    explicit Server(ServerOptions options) : options_(std::move(options)) {}
    Result<void> listen();
    // Something has changed for whoever waits in next().
    void ring();
    std::optional<Arrived> take();

    ServerOptions options_;
    std::string token_, host_;
    int port_ = 0;
    mg_context* context_ = nullptr;

    std::mutex mutex_;  // Of what follows.
    std::condition_variable bell_;
    std::map<PageId, std::shared_ptr<Page>> pages_;
    std::uint64_t rings_ = 0;
    PageId last_page_ = 0, last_served_ = 0;
    bool ending_ = false;
    std::atomic<std::uint64_t> arrived_ = 0, interrupted_ = 0;
};

}  // namespace meld::view
