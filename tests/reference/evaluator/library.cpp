#include "tests/reference/evaluator/library.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

namespace meld::reference {

namespace {

using I = std::int64_t;
using Result = std::optional<Value>;
using Function = std::function<Result(const Values&)>;

bool contains(const Values& list, const Value& x) { return std::find(list.begin(), list.end(), x) != list.end(); }

Values sorted(Values list) {
    std::stable_sort(list.begin(), list.end());
    return list;
}
Values once(const Values& list) {
    Values out;
    for (const Value& x : list)
        if (!contains(out, x)) out.push_back(x);
    return out;
}
Values joined(Values a, const Values& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}
Values filtered(const Values& list, const std::function<bool(const Value&)>& keep) {
    Values out;
    std::copy_if(list.begin(), list.end(), std::back_inserter(out), keep);
    return out;
}
Values between(const Values& list, I from, I to) {
    Values out;
    for (I i = 0; i < static_cast<I>(list.size()); ++i)
        if (i >= from && i < to) out.push_back(list[static_cast<std::size_t>(i)]);
    return out;
}
Result nth(const Values& list, I i) { return i < 0 || i >= static_cast<I>(list.size()) ? Result() : list[static_cast<std::size_t>(i)]; }

Result sum(const Values& list) {
    if (list.empty()) return value_of(I{0});
    Value total = list[0];
    for (std::size_t i = 1; i < list.size(); ++i) {
        I whole = 0;
        if (!total.is_real() && __builtin_add_overflow(total.integer(), list[i].integer(), &whole)) return std::nullopt;
        total = total.is_real() ? value_of(total.real() + list[i].real()) : value_of(whole);
    }
    return total;
}

Result whole(double a) {
    if (!(a >= -9223372036854775808.0 && a < 9223372036854775808.0)) return std::nullopt;
    return value_of(static_cast<I>(a));
}

// Where characters begin; one past the last at the end.
std::vector<std::size_t> characters(const std::string& text) {
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < text.size(); ++i)
        if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) starts.push_back(i);
    starts.push_back(text.size());
    return starts;
}

std::string substring(const std::string& text, I from, I count) {
    const std::vector<std::size_t> starts = characters(text);
    const I all = static_cast<I>(starts.size()) - 1;
    const I begin = std::clamp<I>(from, 0, all), end = std::clamp<I>(from + std::clamp<I>(count, 0, all + 64), begin, all);
    return text.substr(starts[static_cast<std::size_t>(begin)],
                       starts[static_cast<std::size_t>(end)] - starts[static_cast<std::size_t>(begin)]);
}

Values letters(const std::string& text) {
    Values out;
    const std::vector<std::size_t> starts = characters(text);
    for (std::size_t i = 0; i + 1 < starts.size(); ++i) out.push_back({text.substr(starts[i], starts[i + 1] - starts[i])});
    return out;
}

Result number_in(const std::string& text) {
    const std::string digits = text.starts_with('-') ? text.substr(1) : text;
    if (digits.empty() || digits.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    I value = 0;
    for (const char c : digits) {
        const I digit = text[0] == '-' ? '0' - c : c - '0';
        if (__builtin_mul_overflow(value, 10, &value) || __builtin_add_overflow(value, digit, &value)) return std::nullopt;
    }
    return value_of(value);
}

double dot(const Values& a, const Values& b) { return a[0].real() * b[0].real() + a[1].real() * b[1].real() + a[2].real() * b[2].real(); }
Values cross(const Values& a, const Values& b) {
    const auto part = [&](std::size_t i, std::size_t k) { return value_of(a[i].real() * b[k].real() - a[k].real() * b[i].real()); };
    return {part(1, 2), part(2, 0), part(0, 1)};
}
double distance(const Values& a, const Values& b) {
    Values way;
    for (std::size_t i = 0; i < 3; ++i) way.push_back(value_of(a[i].real() - b[i].real()));
    return std::sqrt(dot(way, way));
}

// Both agree in every bit with the kernel, which leaves the same matrices to the same function of Eigen.
using Matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
Matrix nearest_rotation(const Matrix& m) {
    if (!m.allFinite()) return m;
    const Eigen::JacobiSVD<Matrix> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1;
    return u * svd.matrixV().transpose();
}
Value vector_of(double x, double y, double z) { return value_of(Values{value_of(x + 0.0), value_of(y + 0.0), value_of(z + 0.0)}); }
Result rows_of(const Matrix& m) {
    if (!m.allFinite()) return {};
    Values rows;
    for (int i = 0; i < 3; ++i) rows.push_back(vector_of(m(i, 0), m(i, 1), m(i, 2)));
    return value_of(std::move(rows));
}
Result align(const Values& from, const Values& to) {
    if (from.empty() || from.size() != to.size()) return {};
    const auto n = static_cast<double>(from.size());
    const auto at = [](const Value& v, int i) { return v.items()[static_cast<std::size_t>(i)].real(); };
    double a[3] = {}, b[3] = {};
    Matrix m = Matrix::Zero();
    for (std::size_t p = 0; p < from.size(); ++p)
        for (int i = 0; i < 3; ++i) a[i] += at(from[p], i) / n, b[i] += at(to[p], i) / n;
    for (std::size_t p = 0; p < from.size(); ++p)
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) m(i, k) += (at(to[p], i) - b[i]) * (at(from[p], k) - a[k]);
    const Matrix r = nearest_rotation(m);
    double shift[3];
    for (int i = 0; i < 3; ++i) shift[i] = b[i] - (r(i, 0) * a[0] + r(i, 1) * a[1] + r(i, 2) * a[2]);
    const Result rows = rows_of(r);
    return rows ? value_of(joined(rows->items(), {vector_of(shift[0], shift[1], shift[2])})) : rows;
}

const std::map<std::string, Function>& functions() {
    static const auto all = [] {
        std::map<std::string, Function> f;
        f["floor"] = [](const Values& a) { return whole(std::floor(a[0].real())); };
        f["ceil"] = [](const Values& a) { return whole(std::ceil(a[0].real())); };
        f["round"] = [](const Values& a) { return whole(std::round(a[0].real())); };

        f["llength"] = f["ssize"] = f["alength"] =
            f["array_size"] = [](const Values& a) { return value_of(static_cast<I>(a[0].items().size())); };
        f["lnth"] = f["anth"] = f["array_get"] = [](const Values& a) { return nth(a[0].items(), a[1].integer()); };
        f["lhead"] = [](const Values& a) { return nth(a[0].items(), 0); };
        f["llast"] = [](const Values& a) { return nth(a[0].items(), static_cast<I>(a[0].items().size()) - 1); };
        f["ltail"] = [](const Values& a) { return value_of(between(a[0].items(), 1, static_cast<I>(a[0].items().size()))); };
        f["lappend"] = [](const Values& a) { return value_of(joined(a[0].items(), a[1].items())); };
        f["array_init"] = [](const Values& a) { return value_of(Values(static_cast<std::size_t>(std::max(I{0}, a[0].integer())), a[1])); };
        f["ladd"] = f["array_add"] = [](const Values& a) { return value_of(joined(a[0].items(), {a[1]})); };
        f["lreverse"] = [](const Values& a) { return value_of(Values(a[0].items().rbegin(), a[0].items().rend())); };
        f["lsort"] = [](const Values& a) { return value_of(sorted(a[0].items())); };
        f["lexists"] = f["smember"] = f["array_exists"] = [](const Values& a) { return value_of(contains(a[0].items(), a[1])); };
        f["lindex"] = [](const Values& a) {
            const auto at = std::find(a[0].items().begin(), a[0].items().end(), a[1]);
            return value_of(at == a[0].items().end() ? I{-1} : static_cast<I>(at - a[0].items().begin()));
        };
        f["lcount"] = [](const Values& a) { return value_of(static_cast<I>(std::count(a[0].items().begin(), a[0].items().end(), a[1]))); };
        f["ltake"] = [](const Values& a) { return value_of(between(a[0].items(), 0, a[1].integer())); };
        f["ldrop"] = [](const Values& a) { return value_of(between(a[0].items(), a[1].integer(), static_cast<I>(a[0].items().size()))); };
        f["lsublist"] = [](const Values& a) { return value_of(between(a[0].items(), a[1].integer(), a[2].integer())); };
        f["lremove"] = f["ldelete"] =
            f["sremove"] = [](const Values& a) { return value_of(filtered(a[0].items(), [&](const Value& x) { return x != a[1]; })); };
        f["ldiff"] = f["sdiff"] = [](const Values& a) {
            return value_of(filtered(a[0].items(), [&](const Value& x) { return !contains(a[1].items(), x); }));
        };
        f["linter"] = f["sinter"] = [](const Values& a) {
            return value_of(filtered(a[0].items(), [&](const Value& x) { return contains(a[1].items(), x); }));
        };
        f["lunion"] = [](const Values& a) {
            return value_of(joined(a[0].items(), filtered(a[1].items(), [&](const Value& x) { return !contains(a[0].items(), x); })));
        };
        f["lunique"] = [](const Values& a) { return value_of(once(a[0].items())); };
        f["lsubset"] = f["ssubset"] = [](const Values& a) {
            return value_of(
                std::all_of(a[0].items().begin(), a[0].items().end(), [&](const Value& x) { return contains(a[1].items(), x); }));
        };
        f["lequal"] = [](const Values& a) { return value_of(a[0] == a[1]); };
        f["lsum"] = [](const Values& a) { return sum(a[0].items()); };
        f["lmin"] = [](const Values& a) { return nth(sorted(a[0].items()), 0); };
        f["lmax"] = [](const Values& a) { return nth(sorted(a[0].items()), static_cast<I>(a[0].items().size()) - 1); };

        f["list2set"] = [](const Values& a) { return value_of(sorted(once(a[0].items()))); };
        f["set2list"] = f["list2array"] = f["array2list"] = f["array_from_list"] = [](const Values& a) { return a[0]; };
        f["sadd"] = [](const Values& a) { return value_of(sorted(once(joined(a[0].items(), {a[1]})))); };
        f["sunion"] = [](const Values& a) { return value_of(sorted(once(joined(a[0].items(), a[1].items())))); };
        f["aset"] = f["array_set"] = [](const Values& a) {
            Values items = a[0].items();
            if (!nth(items, a[1].integer())) return Result();
            items[static_cast<std::size_t>(a[1].integer())] = a[2];
            return Result(value_of(std::move(items)));
        };

        f["x"] = [](const Values& a) { return a[0].items()[0]; };
        f["y"] = [](const Values& a) { return a[0].items()[1]; };
        f["z"] = [](const Values& a) { return a[0].items()[2]; };
        f["dot"] = [](const Values& a) { return value_of(dot(a[0].items(), a[1].items())); };
        f["cross"] = [](const Values& a) { return value_of(cross(a[0].items(), a[1].items())); };
        f["norm"] = [](const Values& a) { return value_of(std::sqrt(dot(a[0].items(), a[0].items()))); };
        f["distance"] = [](const Values& a) { return value_of(distance(a[0].items(), a[1].items())); };

        f["nearest_rotation"] = [](const Values& a) {
            Matrix m;
            for (int i = 0; i < 3; ++i)
                for (int k = 0; k < 3; ++k) m(i, k) = a[static_cast<std::size_t>(i)].items()[static_cast<std::size_t>(k)].real();
            return rows_of(nearest_rotation(m));
        };
        f["align"] = [](const Values& a) { return align(a[0].items(), a[1].items()); };

        f["strlen"] = [](const Values& a) { return value_of(static_cast<I>(characters(a[0].text()).size()) - 1); };
        f["concat"] = [](const Values& a) { return Value{a[0].text() + a[1].text()}; };
        f["substr"] = [](const Values& a) { return Value{substring(a[0].text(), a[1].integer(), a[2].integer())}; };
        f["str2list"] = [](const Values& a) { return value_of(letters(a[0].text())); };
        f["int2str"] = [](const Values& a) { return Value{fmt::format("{}", a[0].integer())}; };
        f["node2str"] = [](const Values& a) { return Value{fmt::format("@{}", a[0].integer())}; };
        f["str2int"] = [](const Values& a) { return number_in(a[0].text()); };
        return f;
    }();
    return all;
}

}  // namespace

std::optional<Value> call_library(const std::string& name, const Values& arguments) {
    const auto found = functions().find(name);
    if (found == functions().end()) throw std::runtime_error("the reference does not know the function " + name);
    return found->second(arguments);
}

}  // namespace meld::reference
