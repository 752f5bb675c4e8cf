// Reads the keys of a JSON object that a page has sent: each with its type and range, and no others.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/base/error.h"

namespace meld::view {

using Json = nlohmann::ordered_json;

// `message`, `hint` and `code`, as pages are told what is wrong.
Json as_json(const Error& error);
// Messages about a look name the options of meldsim shot, which pages do not have.
Error as_page_says_it(Error error);
// Those of several mistakes, each as above.
Json as_page_says_them(const std::vector<Error>& mistakes);

class Fields {
  public:
    // `what` names the object in messages. The object outlives this.
    Fields(const Json& object, std::string what);

    // Each leaves `value` as it is if the key is missing or null.
    void read(const char* key, std::string& value);
    void read(const char* key, bool& value);
    void read(const char* key, std::int64_t& value, std::int64_t least, std::int64_t most);
    void read(const char* key, double& value, double least, double most);
    void read(const char* key, std::optional<std::int64_t>& value, std::int64_t least, std::int64_t most);
    void read(const char* key, std::optional<double>& value, double least, double most);
    // So many numbers, or none.
    void read(const char* key, std::vector<double>& values, std::size_t count, double least, double most);
    // An object, to be read by Fields of its own; an empty one if the key is missing.
    const Json& object(const char* key);
    // Keys that somebody else reads.
    void known(const char* key) { known_.emplace_back(key); }

    // Errors: the first that was found; a key that nobody has asked for, with what may have been meant.
    Result<void> done() const;

  private:
    const Json* find(const char* key);
    void wrong(const char* key, const std::string& why);

    const Json& object_;
    std::string what_;
    std::vector<std::string_view> known_;
    std::optional<Error> error_;
};

}  // namespace meld::view
