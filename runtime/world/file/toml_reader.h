// Typed reading of a TOML file that stores the first mistake with its place, so that the code that reads a section is a list of its keys.
// After a mistake all values are defaults; the caller checks once, at the end, whether there was one.
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/hash.h"
#include "runtime/world/description/world.h"
#include "runtime/world/file/model_files.h"
#include "runtime/world/shapes/expression.h"

namespace meld::world {

// An error if a key of the file has more parts (`a.b.c` has three) than the library can handle: each part becomes a table inside another,
// and the library walks tables by recursion. It limits the depth of values itself.
Result<void> check_key_depth(std::string_view text, const std::string& path);

class TomlReader {
  public:
    // `files`: those that the text names, if they are not to be read from the disk.
    TomlReader(std::string_view text, const std::string& path, const WorldFiles* files)
        : text_(text), path_(path), files_(files), source_hash_(hash_text(text)) {}

    const std::optional<Error>& error() const { return error_; }
    std::string place(const toml::source_region& source) const;  // "world.toml:12:5".
    // Stores a mistake, if it is the first.
    void wrong(const toml::source_region& source, std::string_view problem, std::string suggestion = {});
    // A mistake within an expression in a string; the place is that of the column if the string is plain.
    void wrong_in(const toml::node& string, const ExpressionError& error);
    void wrong(Error error);
    const std::string& path() const { return path_; }
    // The path of a file that the world names: relative to the folder of the world, unless it is absolute.
    std::string beside(const std::string& name) const;
    // Reads such a file; the errors are those of read_input.
    Result<std::string> read_file(const std::string& path, std::uint64_t most_bytes);
    // The models that shapes of the world name.
    WorldModels& models() { return models_; }
    // The robots of the world, which regions may name from then on.
    void know_robots(std::shared_ptr<const Robots> robots) { robots_ = std::move(robots); }
    Nameable nameable() { return {&models_, robots_}; }
    // Their paths, in order.
    const std::vector<std::string>& files_read() const { return files_read_; }
    // Of the text and of all files read so far.
    std::uint64_t source_hash() const { return source_hash_; }
    std::uint64_t files_hash() const { return files_hash_; }

  private:
    std::string_view line(std::size_t number) const;
    std::string_view text_;
    const std::string& path_;
    const WorldFiles* files_;
    std::vector<std::string> files_read_;
    std::uint64_t source_hash_, files_hash_ = 0;
    std::optional<Error> error_;
    WorldModels models_{*this};
    std::shared_ptr<const Robots> robots_;
};

// "12 is an integer, not a string".
std::string type_mismatch(const toml::node& node, std::string_view wanted);

// A table of the file, by its name in messages: "[limits]".
class Section {
  public:
    // Reports each unknown key.
    Section(TomlReader& reader, const toml::table& table, std::string name, const std::vector<std::string_view>& known);

    const toml::node* find(std::string_view key) const { return table_.get(key); }
    bool has(std::string_view key) const { return find(key) != nullptr; }
    // The value, or the present one if the key is missing or wrong.
    void read(std::string_view key, std::string& value) const;
    void read(std::string_view key, bool& value) const;
    void read(std::string_view key, std::vector<std::string>& value) const;
    // A finite number above zero.
    void read_positive(std::string_view key, double& value) const;
    // A finite number within these bounds.
    void read_number(std::string_view key, double& value, double least = std::numeric_limits<double>::lowest(),
                     double most = std::numeric_limits<double>::max()) const;
    // Three finite numbers, [x, y, z].
    void read(std::string_view key, Vec3& value) const;
    void read(std::string_view key, std::vector<Vec3>& value) const;
    // One of these words.
    void read_choice(std::string_view key, std::string& value, std::initializer_list<std::string_view> choices) const;
    // A whole number, also written "2M".
    void read_count(std::string_view key, std::uint64_t& value, std::uint64_t least = 0,
                    std::uint64_t most = std::numeric_limits<std::int64_t>::max()) const;
    void read_count(std::string_view key, int& value, int least) const;
    // A number of bytes, also written "16GiB".
    void read_bytes(std::string_view key, std::uint64_t& value) const;
    // A time above zero in seconds, also written "1ms".
    void read_seconds(std::string_view key, double& value) const;
    // Expressions in strings.
    std::optional<Region> read_region(std::string_view key) const;
    std::optional<Shape> read_shape(std::string_view key) const;
    const toml::source_region& source() const { return table_.source(); }

    void wrong(std::string_view key, std::string_view problem, std::string suggestion = {}) const;

  private:
    std::string name_of(std::string_view key) const;
    template <class T, class Text>
    std::optional<T> read_parsed(std::string_view key, Parsed<T> (*parse)(Text, Nameable)) const;
    bool read_point(const toml::node& node, const std::string& what, Vec3& value) const;
    void read_suffixed(std::string_view key, std::uint64_t& value, std::uint64_t least, std::uint64_t most,
                       Result<std::uint64_t> (*parse)(std::string_view)) const;
    TomlReader& reader_;
    const toml::table& table_;
    std::string name_;
};

}  // namespace meld::world
