// The messages of the Debug Adapter Protocol: `Content-Length: N`, an empty line, and N bytes of JSON, which are a request, a response or
// an event.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "runtime/base/error.h"

namespace meld::dap {

using Json = nlohmann::ordered_json;

// Larger messages are none of the protocol.
inline constexpr std::size_t kMaxMessage_bytes = std::size_t{1} << 24;
inline constexpr std::size_t kMaxHeader_bytes = std::size_t{1} << 12;
inline constexpr int kMaxDepth = 100;

// Takes bytes as they come, and gives messages.
class Reader {
  public:
    void add(std::string_view bytes) { bytes_ += bytes; }
    // The text of the next message; nothing if not all of it has come. Errors: these are no messages, and where the next one would begin
    // cannot be known.
    Result<std::optional<std::string>> next();

  private:
    std::string bytes_;
};

struct Request {
    std::int64_t seq = 0;
    std::string command = {};
    Json arguments = Json::object();
};

// Errors: it is no JSON, or no request; or it is nested too deeply.
Result<Request> parse_request(const std::string& text);

// Numbers what is sent. Bytes that are no UTF-8 are replaced.
class Writer {
  public:
    explicit Writer(std::function<void(const std::string&)> send) : send_(std::move(send)) {}

    void respond(const Request& request, Json body = nullptr);
    // `message` is shown to people.
    void refuse(const Request& request, const std::string& message);
    void event(const std::string& name, Json body = nullptr);
    // What the client shows in its console; `category` as of the protocol.
    void output(const std::string& category, const std::string& text);

  private:
    void send(Json message);

    std::function<void(const std::string&)> send_;
    std::int64_t seq_ = 0;
};

}  // namespace meld::dap
