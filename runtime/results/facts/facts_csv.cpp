#include "runtime/results/facts/facts_csv.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>

#include "runtime/base/csv_row.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/version.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::record {

namespace {

// What the description of a folder says of who has written it.
constexpr std::string_view kCreator = "claymeld";
constexpr std::uint64_t kMostOfADescription = 64 << 20;  // Bytes

std::string cell(const ModuleInfo& module, const PredicateInfo& p, const TableColumn& column, const Value* arguments) {
    const tuple::Type type = tuple::type_of(module, p.fields[column.argument]);
    const Value value = arguments[column.argument];
    switch (column.type) {
        case CellType::Node:
            return std::to_string(value.catom);
        case CellType::Float:
            if (type.kind() == ValueType::Vec3) return tuple::print_value(type.item(column.item), tuple::item(value.list, column.item));
            return tuple::print_value(type, value);
        case CellType::Text:
            return csv_field(tuple::print_plain(type, value));
        case CellType::Int:
        case CellType::Bool:
            return tuple::print_value(type, value);
    }
    return "";
}

std::string heading(const FactTable& table) {
    std::string text = kCatomColumn;
    for (const TableColumn& column : table.columns) text += "," + column.name;
    return text + "\n";
}

// One table in one file or stream.
class CsvFile : public FactsFile {
  public:
    explicit CsvFile(OutputFile file) : file_(std::move(file)) {}
    void begin(const FactTable& table) override { file_.write(heading(table)); }
    void rows(std::span<const std::byte> packed) override { file_.write({reinterpret_cast<const char*>(packed.data()), packed.size()}); }
    Result<void> commit() override { return file_.commit(); }

  private:
    OutputFile file_;
};

const char* field_type(CellType type) {
    switch (type) {
        case CellType::Int:
        case CellType::Node:
            return "integer";
        case CellType::Float:
            return "number";
        case CellType::Bool:
            return "boolean";
        case CellType::Text:
            return "string";
    }
    return "";
}

// The description of a folder, in which "meld" is the type of a column in Meld.
std::string description(const ModuleInfo& module, const std::vector<FactTable>& tables) {
    nlohmann::ordered_json resources = nlohmann::ordered_json::array();
    for (const FactTable& table : tables) {
        nlohmann::ordered_json fields = {{{"name", kCatomColumn}, {"type", field_type(CellType::Node)}, {"meld", "node"}}};
        for (const TableColumn& column : table.columns)
            fields.push_back({{"name", column.name}, {"type", field_type(column.type)}, {"meld", column_type(module, table, column)}});
        resources.push_back(
            {{"name", table.name}, {"path", table.name + ".csv"}, {"encoding", "utf-8"}, {"schema", {{"fields", std::move(fields)}}}});
    }
    const nlohmann::ordered_json json = {
        {"name", "facts"}, {"created_by", kCreator}, {"version", kVersion}, {"resources", std::move(resources)}};
    return json.dump(2) + "\n";
}

// A folder that did not exist before the run and goes again if nothing has come into it.
class MadeFolder {
  public:
    explicit MadeFolder(std::string path) : path_(std::move(path)) {}
    MadeFolder(MadeFolder&& other) noexcept : path_(std::exchange(other.path_, "")) {}
    MadeFolder& operator=(MadeFolder&&) = delete;
    ~MadeFolder() {
        if (!path_.empty()) rmdir(path_.c_str());
    }

  private:
    std::string path_;
};

class CsvFolder : public FactsFile {
  public:
    CsvFolder(MadeFolder folder, std::vector<OutputFile> files, std::string description)
        : folder_(std::move(folder)), files_(std::move(files)), description_(std::move(description)) {}
    void begin(const FactTable& table) override { files_.at(begun_++).write(heading(table)); }
    void rows(std::span<const std::byte> packed) override {
        files_[begun_ - 1].write({reinterpret_cast<const char*>(packed.data()), packed.size()});
    }
    // All tables are whole before the first one replaces an earlier one. The description comes last.
    Result<void> commit() override {
        files_.back().write(description_);
        for (OutputFile& file : files_)
            if (auto written = file.flush(); !written) return written;
        for (OutputFile& file : files_)
            if (auto written = file.commit(); !written) return written;
        return {};
    }

  private:
    MadeFolder folder_;              // Goes after the locks in it.
    std::vector<OutputFile> files_;  // Of the tables, then of the description.
    std::size_t begun_ = 0;
    std::string description_;
};

std::string names_of(const std::vector<FactTable>& tables) {
    std::string text;
    for (std::size_t i = 0; i < tables.size(); ++i) text += (i == 0 ? "" : i + 1 == tables.size() ? " and " : ", ") + tables[i].name;
    return text;
}

// Whether the folder has been described by a run. Errors: it is described as other data.
Result<bool> is_described(const std::string& folder) {
    const std::string package = folder + kDataPackage;
    std::error_code error;
    if (!std::filesystem::exists(package, error)) return false;
    const Result<std::string> text = read_input(package, kMostOfADescription);
    if (!text) return tl::unexpected(text.error());
    const nlohmann::json json = nlohmann::json::parse(*text, nullptr, false);
    if (json.is_object() && json.contains("created_by") && json["created_by"] == kCreator) return true;
    return fail(fmt::format("cannot write {}: its {} describes other data", folder, kDataPackage), "Choose another folder");
}

// Nothing in the folder is another's: no table that the run does not write, or that no run has written, no description of other data.
Result<void> check_folder(const std::string& path, const std::vector<FactTable>& tables) {
    const Result<bool> described = is_described(path);
    if (!described) return tl::unexpected(described.error());
    std::vector<std::string> strangers;
    std::error_code error;
    for (auto it = std::filesystem::directory_iterator(path, error); !error && it != std::filesystem::directory_iterator();
         it.increment(error)) {
        const std::filesystem::path file = it->path().filename();
        const bool named = std::ranges::any_of(tables, [&](const FactTable& table) { return table.name == file.stem(); });
        if (file.extension() == ".csv" && !(named && *described)) strangers.push_back(file.string());
    }
    if (error) return tl::unexpected(cannot_write(path, error.value()));
    if (strangers.empty()) return {};
    return fail(fmt::format("cannot write {}: it has a table that is none of this run, {}", path, std::ranges::min(strangers)),
                "Remove it, or choose another folder");
}

}  // namespace

void pack_csv(const ModuleInfo& module, const FactTable& table, u64 id, const Value* arguments, ByteWriter& out) {
    const PredicateInfo& p = module.predicates[table.predicate];
    std::string text = std::to_string(id);
    for (const TableColumn& column : table.columns) text += "," + cell(module, p, column, arguments);
    text += '\n';
    out.write_bytes(text.data(), text.size());
}

Result<std::unique_ptr<FactsFile>> open_csv(const std::string& path, const ModuleInfo& module, Durability durability) {
    const std::vector<FactTable> tables = fact_tables(module);
    if (tables.empty()) return fail(fmt::format("cannot write {}: the program stores no facts", path), "Leave out --facts-out");
    if (tables.size() > 1)
        return fail(
            fmt::format("cannot write {}: a CSV file holds one table, and the program has {}: {}", path, tables.size(), names_of(tables)),
            fmt::format("Write {0}/ for a folder with a CSV file of each, or {0}.h5", path.substr(0, path.size() - 4)));
    auto file = OutputFile::open(path, Appears::Whole, durability);
    if (!file) return tl::unexpected(file.error());
    return std::make_unique<CsvFile>(std::move(*file));
}

Result<std::unique_ptr<FactsFile>> open_csv_folder(const std::string& path, const ModuleInfo& module, Durability durability) {
    const std::vector<FactTable> tables = fact_tables(module);
    const bool made = mkdir(path.c_str(), 0777) == 0;
    if (!made && errno != EEXIST) return tl::unexpected(cannot_write(path, errno));
    MadeFolder folder(made ? path : "");
    if (auto free = check_folder(path, tables); !free) return tl::unexpected(free.error());
    std::vector<std::string> names;
    for (const FactTable& table : tables) names.push_back(table.name + ".csv");
    names.emplace_back(kDataPackage);
    std::vector<OutputFile> files;
    files.reserve(names.size());
    for (const std::string& name : names) {
        auto file = OutputFile::open(path + name, Appears::Whole, durability);
        if (!file) return tl::unexpected(file.error());
        files.push_back(std::move(*file));
    }
    return std::make_unique<CsvFolder>(std::move(folder), std::move(files), description(module, tables));
}

}  // namespace meld::record
