// Facts read from HDF5 tables: rows are packed structures whose first member is the catom.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>
#include <utility>

#include "runtime/base/csv_row.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/results/facts/fact_tables.h"
#include "runtime/results/facts/facts_reader.h"
#include "runtime/results/hdf5/file_kind.h"
#include "runtime/results/hdf5/hdf5_library.h"
#include "runtime/results/hdf5/hdf5_reading.h"

namespace meld::record {

namespace {

constexpr hsize_t kFactsAtOnce = 8192;
constexpr std::size_t kMaxRow_bytes = 1 << 16;

std::string print_float(double value) {
    static const TypeInfo real = [] {
        TypeInfo info{};
        info.kind = ValueType::Float;
        return info;
    }();
    Value v{};
    v.real = value;
    return tuple::print_value(tuple::Type(&real, 0), v);
}

enum class Cell { Int, Float, Bool, Text };
struct Member {
    Cell cell;
    std::size_t offset;
};

class Hdf5FactsReader : public FactsReader {
  public:
    explicit Hdf5FactsReader(const std::string& path) : path_(path), file_(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose) {}
    ~Hdf5FactsReader() override { give_texts_back(); }

    Result<void> find_tables();
    const std::vector<Table>& tables() const override { return tables_; }
    Result<void> begin(std::size_t table) override;
    Result<bool> next(FactRow& row) override;

  private:
    tl::unexpected<Error> damaged(const std::string& what) const {
        return fail(fmt::format("cannot read {}: {}", path_, what), "It is damaged, or was written by another version",
                    ExitCode::RecordingRefused);
    }
    Result<std::string> open_table(const std::string& name);
    Result<void> read_rows();
    void give_texts_back();
    template <class T>
    T at(std::size_t offset) const {
        T value;
        std::memcpy(&value, rows_.data() + row_ * row_bytes_ + offset, sizeof value);
        return value;
    }

    std::string path_;
    Handle file_;
    std::vector<Table> tables_;
    // The table that is being read.
    std::optional<Handle> dataset_, type_;
    std::vector<Member> members_;
    std::size_t row_bytes_ = 0;
    hsize_t count_ = 0, read_ = 0;  // Rows of the table; how many of them have been in memory.
    std::vector<std::byte> rows_;
    std::size_t row_ = 0, here_ = 0;  // The next row in memory, of so many.
};

// The texts of the rows in memory are the library's.
void Hdf5FactsReader::give_texts_back() {
    for (row_ = 0; row_ < here_; ++row_)
        for (const Member& member : members_)
            if (member.cell == Cell::Text) H5free_memory(at<char*>(member.offset));
    row_ = here_ = 0;
}

// Returns the names of the columns.
Result<std::string> Hdf5FactsReader::open_table(const std::string& name) {
    give_texts_back();
    members_.clear();
    dataset_.emplace(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
    const Handle stored(H5Dget_type(*dataset_), H5Tclose), space(H5Dget_space(*dataset_), H5Sclose);
    if (*dataset_ < 0 || H5Tget_class(stored) != H5T_COMPOUND || H5Sget_simple_extent_ndims(space) != 1)
        return damaged(fmt::format("{} is no table", name));
    type_.emplace(H5Tget_native_type(stored, H5T_DIR_ASCEND), H5Tclose);
    row_bytes_ = H5Tget_size(*type_);
    H5Sget_simple_extent_dims(space, &count_, nullptr);
    read_ = 0;
    if (row_bytes_ == 0 || row_bytes_ > kMaxRow_bytes) return damaged(fmt::format("the rows of {} are not as we write them", name));
    std::string columns;
    for (int i = 0; i < H5Tget_nmembers(*type_); ++i) {
        const auto index = static_cast<unsigned>(i);
        const Handle member(H5Tget_member_type(*type_, index), H5Tclose);
        const H5T_class_t kind = H5Tget_class(member);
        const std::size_t size = H5Tget_size(member);
        const bool text = kind == H5T_STRING && H5Tis_variable_str(member) > 0;
        if (!text && !(kind == H5T_INTEGER && size == 8) && !(kind == H5T_FLOAT && size == 8) && !(kind == H5T_ENUM && size == 1))
            return damaged(fmt::format("column {} of {} is not as we write it", i, name));
        members_.push_back({text                  ? Cell::Text
                            : kind == H5T_INTEGER ? Cell::Int
                            : kind == H5T_FLOAT   ? Cell::Float
                                                  : Cell::Bool,
                            H5Tget_member_offset(*type_, index)});
        char* const column = H5Tget_member_name(*type_, index);
        columns += (i == 0 ? "" : ",") + std::string(column);
        H5free_memory(column);
    }
    if (members_.empty() || members_[0].cell != Cell::Int) return damaged(fmt::format("the first column of {} has no numbers", name));
    if (columns != kCatomColumn && !columns.starts_with(std::string(kCatomColumn) + ","))
        return damaged(fmt::format("the first column of {} is not that of the catoms", name));
    return columns;
}

Result<void> Hdf5FactsReader::find_tables() {
    if (file_ < 0) return damaged(text_of_last_error());
    if (const std::string version = attribute(file_, "/", "version"); version != std::to_string(kFactsVersion))
        return fail(fmt::format("{} has facts in version {} of the format, and this meldsim reads version {}", path_,
                                version.empty() ? "none" : version, kFactsVersion),
                    "Read it with the meldsim that wrote it", ExitCode::RecordingRefused);
    const Result<std::vector<std::string>> names = names_in(file_, "/");
    if (!names) return damaged(names.error().problem);
    for (const std::string& name : *names) {
        Result<std::string> columns = open_table(name);
        if (!columns) return tl::unexpected(columns.error());
        tables_.push_back({.name = name, .columns = std::move(*columns)});
    }
    return {};
}

Result<void> Hdf5FactsReader::begin(std::size_t table) {
    const Result<std::string> columns = open_table(tables_[table].name);
    return columns ? Result<void>{} : tl::unexpected(columns.error());
}

Result<void> Hdf5FactsReader::read_rows() {
    give_texts_back();
    const hsize_t more = std::min(kFactsAtOnce, count_ - read_);
    rows_.assign(more * row_bytes_, std::byte{0});
    const Handle there(H5Dget_space(*dataset_), H5Sclose), here(H5Screate_simple(1, &more, nullptr), H5Sclose);
    if (H5Sselect_hyperslab(there, H5S_SELECT_SET, &read_, nullptr, &more, nullptr) < 0 ||
        H5Dread(*dataset_, *type_, here, there, H5P_DEFAULT, rows_.data()) < 0)
        return damaged(text_of_last_error());
    here_ = more;
    read_ += more;
    return {};
}

Result<bool> Hdf5FactsReader::next(FactRow& row) {
    if (row_ == here_) {
        if (read_ == count_) return false;
        if (const auto done = read_rows(); !done) return tl::unexpected(done.error());
    }
    row.catom = at<std::uint64_t>(members_[0].offset);
    row.text = std::to_string(row.catom);
    for (std::size_t i = 1; i < members_.size(); ++i) {
        row.text += ',';
        switch (members_[i].cell) {
            case Cell::Int:
                row.text += std::to_string(at<std::int64_t>(members_[i].offset));
                break;
            case Cell::Float:
                row.text += print_float(at<double>(members_[i].offset));
                break;
            case Cell::Bool:
                row.text += at<std::int8_t>(members_[i].offset) != 0 ? "true" : "false";
                break;
            case Cell::Text: {
                const char* const text = at<const char*>(members_[i].offset);
                row.text += csv_field(text == nullptr ? "" : text);
            }
        }
    }
    ++row_;
    return true;
}

}  // namespace

Result<std::unique_ptr<FactsReader>> read_hdf5_facts(const std::string& path) {
    set_up_library_once();
    auto out = std::make_unique<Hdf5FactsReader>(path);
    if (const auto found = out->find_tables(); !found) return tl::unexpected(found.error());
    return out;
}

}  // namespace meld::record
