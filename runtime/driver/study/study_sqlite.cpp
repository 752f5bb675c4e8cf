// The only use of SQLite: the results of a study as one file that other programs read.
#include <fmt/format.h>
#include <sqlite3.h>

#include <memory>

#include "runtime/base/files/output_file.h"
#include "runtime/base/version.h"
#include "runtime/driver/study/study_table.h"

namespace meld::driver {

namespace {

std::string quoted_name(const std::string& name) {
    std::string text = "\"";
    for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
    return text + "\"";
}

// One value, in the place of a question mark.
void bind(sqlite3_stmt* statement, int at, const StudyCell& cell) {
    if (const auto* whole = std::get_if<std::int64_t>(&cell))
        sqlite3_bind_int64(statement, at, *whole);
    else if (const auto* number = std::get_if<double>(&cell))
        sqlite3_bind_double(statement, at, *number);
    else if (const auto* text = std::get_if<std::string>(&cell))
        sqlite3_bind_text(statement, at, text->data(), static_cast<int>(text->size()), SQLITE_STATIC);
    else
        sqlite3_bind_null(statement, at);
}

class Database {
  public:
    bool run(const std::string& text) { return sqlite3_exec(handle_.get(), text.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK; }
    bool open() {
        sqlite3* handle = nullptr;
        const int code = sqlite3_open(":memory:", &handle);
        handle_.reset(handle);
        return code == SQLITE_OK;
    }
    bool insert(const std::string& text, const std::vector<std::vector<StudyCell>>& rows) {
        sqlite3_stmt* made = nullptr;
        if (sqlite3_prepare_v2(handle_.get(), text.c_str(), -1, &made, nullptr) != SQLITE_OK) return false;
        const std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> statement(made, sqlite3_finalize);
        for (const auto& row : rows) {
            for (std::size_t i = 0; i < row.size(); ++i) bind(made, static_cast<int>(i + 1), row[i]);
            if (sqlite3_step(made) != SQLITE_DONE) return false;
            sqlite3_reset(made);
        }
        return true;
    }
    // The file as bytes, so that it is written as every other result is.
    std::string bytes() {
        sqlite3_int64 size = 0;
        unsigned char* const data = sqlite3_serialize(handle_.get(), "main", &size, 0);
        std::string out;
        if (data != nullptr) out.assign(reinterpret_cast<const char*>(data), static_cast<std::size_t>(size));
        sqlite3_free(data);
        return out;
    }
    std::string problem() const { return sqlite3_errmsg(handle_.get()); }

  private:
    struct Close {
        void operator()(sqlite3* handle) const { sqlite3_close(handle); }
    };
    std::unique_ptr<sqlite3, Close> handle_;
};

}  // namespace

Result<void> write_sqlite(const StudyTable& table, const Study& study, const std::string& path) {
    std::string columns, marks;
    for (const std::string& name : table.columns) {
        columns += (columns.empty() ? "" : ", ") + quoted_name(name);
        marks += marks.empty() ? "?" : ", ?";
    }
    Database database;
    const bool made = database.open() && database.run("CREATE TABLE rows (" + columns + "); CREATE TABLE study (name, value); BEGIN") &&
                      database.insert("INSERT INTO rows VALUES (" + marks + ")", table.rows) &&
                      database.insert("INSERT INTO study VALUES (?, ?)",
                                      {{std::string("study"), study.text}, {std::string("version"), std::string(kVersion)}}) &&
                      database.run("COMMIT");
    const std::string bytes = made ? database.bytes() : "";
    if (bytes.empty()) return fail(fmt::format("cannot make {}: {}", path, database.problem()), "", ExitCode::LimitHit);
    return write_file(path, bytes);
}

}  // namespace meld::driver
