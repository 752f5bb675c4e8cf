// What one page and the owner of the run have to tell each other, between the threads that read and write its connection.
//
// A page is never waited for by the owner, and never makes it keep much: its requests wait in the connection when there are too many, its
// requests are not taken while it has not read the answers to earlier ones, and of each kind of news only the last is kept.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

namespace meld::view {

// A text message, and the binary one that follows it, if any.
struct Sent {
    std::string kind = {};  // Of news, such as "moved"; empty: an answer.
    std::string text = {};
    std::string binary = {};
};

class Mailbox {
  public:
    struct Request {
        std::uint64_t number = 0;  // In the order in which they came, of all pages.
        std::string text = {};
    };

    // By the thread that reads the connection. Waits while many requests wait. False: it has been closed.
    bool put(Request request);
    // By the owner: the oldest request, if the page has read nearly all that it was sent.
    std::optional<Request> take();
    void send(Sent sent);
    // By the thread that writes the connection, when it has written the one before. Waits; nothing at the end.
    std::optional<Sent> next_to_write();
    // Nothing more comes or goes; what waits is dropped.
    void close();

  private:
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Request> requests_;
    std::deque<Sent> to_write_;
    std::size_t waiting_bytes_ = 0;  // Of what is not written yet,
    std::size_t writing_bytes_ = 0;  // with what is being written.
    bool closed_ = false;
};

}  // namespace meld::view
