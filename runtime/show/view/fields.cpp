#include "runtime/show/view/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "runtime/base/did_you_mean.h"
#include "runtime/base/shallow_json.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::view {

namespace {

const Json& nothing() {
    static const Json empty = Json::object();
    return empty;
}

}  // namespace

Json as_json(const Error& error) {
    return {{"message", error.problem}, {"hint", error.suggestion}, {"code", static_cast<int>(error.code)}};
}

Error as_page_says_it(Error error) {
    const std::size_t end = error.problem.find(": ");
    if (error.problem.starts_with("--") && end != std::string::npos) error.problem.erase(0, 2);
    return error;
}

Json as_page_says_them(const std::vector<Error>& mistakes) {
    Json out = Json::array();
    for (const Error& mistake : mistakes) out.push_back(as_json(as_page_says_it(mistake)));
    return out;
}

Fields::Fields(const Json& object, std::string what) : object_(object), what_(std::move(what)) {
    if (!object_.is_object()) error_ = Error{fmt::format("{} is no JSON object", what_)};
}

const Json* Fields::find(const char* key) {
    known_.emplace_back(key);
    if (!object_.is_object()) return nullptr;
    const auto at = object_.find(key);
    return at == object_.end() || at->is_null() ? nullptr : &*at;
}

void Fields::wrong(const char* key, const std::string& why) {
    if (!error_) error_ = Error{fmt::format("{}: \"{}\" is {}", what_, key, why)};
}

void Fields::read(const char* key, std::string& value) {
    const Json* const found = find(key);
    if (found == nullptr) return;
    if (!found->is_string()) return wrong(key, "no string");
    value = found->get<std::string>();
}

void Fields::read(const char* key, bool& value) {
    const Json* const found = find(key);
    if (found == nullptr) return;
    if (!found->is_boolean()) return wrong(key, "neither true nor false");
    value = found->get<bool>();
}

void Fields::read(const char* key, std::int64_t& value, std::int64_t least, std::int64_t most) {
    std::optional<std::int64_t> given;
    read(key, given, least, most);
    value = given.value_or(value);
}

void Fields::read(const char* key, double& value, double least, double most) {
    std::optional<double> given;
    read(key, given, least, most);
    value = given.value_or(value);
}

void Fields::read(const char* key, std::optional<std::int64_t>& value, std::int64_t least, std::int64_t most) {
    const Json* const found = find(key);
    if (found == nullptr) return;
    const std::optional<std::int64_t> number = if_whole_number(*found, least, most);
    if (!number) return wrong(key, fmt::format("no whole number from {} to {}", least, most));
    value = number;
}

void Fields::read(const char* key, std::optional<double>& value, double least, double most) {
    const Json* const found = find(key);
    if (found == nullptr) return;
    if (!found->is_number() || !(found->get<double>() >= least && found->get<double>() <= most))
        return wrong(key, fmt::format("no number from {} to {}", least, most));
    value = found->get<double>();
}

void Fields::read(const char* key, std::vector<double>& values, std::size_t count, double least, double most) {
    const Json* const found = find(key);
    if (found == nullptr) return;
    const auto fits = [&](const Json& each) { return each.is_number() && each.get<double>() >= least && each.get<double>() <= most; };
    if (!found->is_array() || found->size() != count || !std::ranges::all_of(*found, fits))
        return wrong(key, fmt::format("no array of {} numbers from {} to {}", count, least, most));
    values = found->get<std::vector<double>>();
}

const Json& Fields::object(const char* key) {
    const Json* const found = find(key);
    if (found == nullptr) return nothing();
    if (!found->is_object()) wrong(key, "no object");
    return *found;
}

Result<void> Fields::done() const {
    if (error_) return tl::unexpected<Error>(*error_);
    for (const auto& [key, value] : object_.items()) {
        if (std::ranges::find(known_, key) != known_.end()) continue;
        const auto near = nearest_name(key, known_);
        return fail(fmt::format("{} has no \"{}\"", what_, visible(key)), near ? fmt::format("Did you mean \"{}\"?", *near) : "");
    }
    return {};
}

}  // namespace meld::view
