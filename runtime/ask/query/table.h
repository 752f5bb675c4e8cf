// The answer to a question: a table with its variables as columns.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "runtime/ask/facts/types.h"
#include "runtime/engine/tuple/values.h"

namespace meld::inspect {

class Table {
  public:
    struct Column {
        std::string name;
        check::Type type;
    };

    Table() = default;
    explicit Table(std::vector<Column> columns) : columns_(std::move(columns)), types_(std::make_unique<Types>()) {}

    // Copies one value for each column. Rows that come again take no memory for long.
    void add(const std::vector<Value>& row);
    // Puts rows in order, by the first column, then the next, and drops those that come again.
    void finish();

    const std::vector<Column>& columns() const { return columns_; }
    std::uint64_t rows() const { return rows_; }
    Value cell(std::size_t row, std::size_t column) const { return values_[row * columns_.size() + column]; }

    // A value as the language writes it.
    std::string text(std::size_t row, std::size_t column) const;
    // The same, but a string is only what is in it.
    std::string plain(std::size_t row, std::size_t column) const;
    // Each with at most so many rows. Text has a line of names, and a line for each row; without columns, "yes" or "no".
    std::string to_text(std::uint64_t most_rows) const;
    // As in files of facts: catoms as their numbers; strings and whatever has parts as text.
    std::string to_csv(std::uint64_t most_rows) const;
    // Numbers, bools, strings and lists as those of JSON, catoms as their numbers; columns() says which they are.
    nlohmann::ordered_json columns_json() const;
    nlohmann::ordered_json rows_json(std::uint64_t most_rows) const;

    // Values that could not be computed, so that something may be missing.
    std::uint64_t failures = 0;
    std::string first_failure = {};

  private:
    static constexpr std::uint64_t kLeastFinished = std::uint64_t{1} << 20;
    Value copied(tuple::Type type, Value v, tuple::Arena& lists) const;
    tuple::Type type(std::size_t column) const { return types_->of(columns_[column].type); }

    std::vector<Column> columns_;
    std::unique_ptr<Types> types_;
    std::vector<Value> values_;
    std::uint64_t rows_ = 0;
    std::uint64_t next_finish_ = kLeastFinished;  // Rows that come again are dropped when there are so many.
    tuple::Arena lists_;
};

}  // namespace meld::inspect
