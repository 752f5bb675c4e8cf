#include "runtime/ask/dap/message.h"

#include <fmt/format.h>
#include <strings.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "runtime/base/shallow_json.h"

namespace meld::dap {

namespace {

constexpr std::string_view kLength = "content-length:";

// Of the header that has this text. Nothing: it does not say, or nothing that can be.
std::optional<std::size_t> length_in(std::string_view header) {
    std::optional<std::size_t> length;
    while (!header.empty()) {
        const std::size_t end = std::min(header.find('\n'), header.size());
        std::string_view line = header.substr(0, end);
        header.remove_prefix(std::min(end + 1, header.size()));
        if (line.size() < kLength.size() || strncasecmp(line.data(), kLength.data(), kLength.size()) != 0) continue;
        line.remove_prefix(kLength.size());
        line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
        std::size_t value = 0;
        const auto [last, error] = std::from_chars(line.data(), line.data() + line.size(), value);
        if (error != std::errc{} || last != line.data() + line.size()) return std::nullopt;
        length = value;
    }
    return length;
}

// Where the header ends and where the text begins.
std::optional<std::pair<std::size_t, std::size_t>> end_of_header(std::string_view bytes) {
    for (std::size_t at = 0; (at = bytes.find('\n', at)) != std::string_view::npos; ++at) {
        if (bytes.substr(at + 1).starts_with('\n')) return std::pair{at + 1, at + 2};
        if (bytes.substr(at + 1).starts_with("\r\n")) return std::pair{at + 1, at + 3};
    }
    return std::nullopt;
}

}  // namespace

Result<std::optional<std::string>> Reader::next() {
    const auto header = end_of_header(std::string_view(bytes_).substr(0, kMaxHeader_bytes));
    if (!header && bytes_.size() < kMaxHeader_bytes) return std::nullopt;
    const auto length = header ? length_in(std::string_view(bytes_).substr(0, header->first)) : std::nullopt;
    if (!length) return fail("what comes is not the Debug Adapter Protocol: a header with Content-Length is missing");
    if (*length > kMaxMessage_bytes)
        return fail(fmt::format("a message of {} bytes is too large: there may be {}", *length, kMaxMessage_bytes));
    if (bytes_.size() - header->second < *length) return std::nullopt;
    std::string text = bytes_.substr(header->second, *length);
    bytes_.erase(0, header->second + *length);
    return text;
}

Result<Request> parse_request(const std::string& text) {
    const std::optional<Json> read = parse_shallow<Json>(text, kMaxDepth);
    if (!read) return fail(fmt::format("a message is nested more than {} deep", kMaxDepth));
    const Json& json = *read;
    if (json.is_discarded()) return fail("a message is not JSON");
    const auto is = [&](const char* key, bool (Json::*kind)() const noexcept) { return json.contains(key) && (json[key].*kind)(); };
    if (!json.is_object() || !is("seq", &Json::is_number_integer) || !is("type", &Json::is_string) || json["type"] != "request" ||
        !is("command", &Json::is_string))
        return fail("a message is no request");
    Request request{.seq = json["seq"].get<std::int64_t>(), .command = json["command"].get<std::string>()};
    if (is("arguments", &Json::is_object)) request.arguments = json["arguments"];
    return request;
}

void Writer::send(Json message) {
    Json numbered = {{"seq", ++seq_}};
    numbered.update(message);
    const std::string text = numbered.dump(-1, ' ', false, Json::error_handler_t::replace);
    send_(fmt::format("Content-Length: {}\r\n\r\n{}", text.size(), text));
}

void Writer::respond(const Request& request, Json body) {
    Json message = {{"type", "response"}, {"request_seq", request.seq}, {"success", true}, {"command", request.command}};
    if (!body.is_null()) message["body"] = std::move(body);
    send(std::move(message));
}

void Writer::refuse(const Request& request, const std::string& message) {
    // The first text is for programs, the second for people; nothing in it is to be replaced.
    send({{"type", "response"},
          {"request_seq", request.seq},
          {"success", false},
          {"command", request.command},
          {"message", message},
          {"body", {{"error", {{"id", 1}, {"format", message}, {"showUser", true}}}}}});
}

void Writer::event(const std::string& name, Json body) {
    Json message = {{"type", "event"}, {"event", name}};
    if (!body.is_null()) message["body"] = std::move(body);
    send(std::move(message));
}

void Writer::output(const std::string& category, const std::string& text) { event("output", {{"category", category}, {"output", text}}); }

}  // namespace meld::dap
