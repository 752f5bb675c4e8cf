#include "runtime/base/csv_row.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace meld {
namespace {

using Fields = std::vector<std::string>;

// The fields, each with its column, or the error.
std::string split(std::string_view line, char separator = ',') {
    CsvRow row(separator);
    const auto fields = row.split(line, "f.csv", 7);
    if (!fields) return fields.error().message();
    std::string out;
    for (std::size_t i = 0; i < fields->size(); ++i)
        out += (i == 0 ? "" : "|") + std::string((*fields)[i]) + "@" + std::to_string(row.column(i));
    return out;
}

TEST(CsvRow, FieldsAreThoseOfRfc4180) {
    const std::tuple<const char*, char, const char*> rows[] = {
        {"a,b", ',', "a@1|b@3"},
        {" a , b\r", ',', "a@2|b@6"},
        {"a,,", ',', "a@1|@3|@4"},
        {"\"a\",\"\"", ',', "a@2|@6"},
        {"a,\"san \"\"f\"\"\"", ',', "a@1|san \"f\"@4"},
        {"a,\"san \"\"g\"\"\"", ',', "a@1|san \"g\"@4"},
        {"\"\"\"\"", ',', "\"@2"},
        {"\"a,b\" , \"c\"", ',', "a,b@2|c@10"},
        {"\"a;b\";c", ';', "a;b@2|c@7"},
        {"\"a\tb\"\t\tc", '\t', "a\tb@2|@7|c@8"},
        {"  a  \"b c\"\t d ", ' ', "a@3|b c@7|d@13"},
        {"\"a \"\"b\"\"\" c", ' ', "a \"b\"@2|c@11"},
    };
    for (const auto& [line, separator, fields] : rows) EXPECT_EQ(split(line, separator), fields) << line;
}

TEST(CsvRow, MistakesHaveTheirPlaceAndACure) {
    const std::string twice = "write a quote inside a quoted field twice: \"say \"\"hi\"\"\"";
    for (const char separator : {',', ';', '\t', ' '}) {
        const std::string a = std::string("a") + separator;
        EXPECT_THAT(split(a + "\"b", separator), testing::StartsWith("f.csv:7:3: this quote is not closed. end the field with a quote on"));
        EXPECT_THAT(split(a + "\"b\"\"", separator), testing::StartsWith("f.csv:7:3: this quote is not closed"));
        EXPECT_EQ(split(a + "\"b\"c", separator), "f.csv:7:6: text follows the quote that ends a field. " + twice);
        EXPECT_EQ(split(a + "\"b\"c\"", separator), "f.csv:7:6: text follows the quote that ends a field. " + twice);
        EXPECT_THAT(split(a + "b\"c\"", separator),
                    testing::StartsWith("f.csv:7:4: a quote inside a field that does not begin with one. "));
    }
    EXPECT_THAT(split("\"b\" c"), testing::StartsWith("f.csv:7:5: text follows"));
}

TEST(CsvRow, SeparatorsInQuotesDoNotCount) {
    EXPECT_EQ(CsvRow::separator_of("a,b;c"), ',');
    EXPECT_EQ(CsvRow::separator_of("\"a,b\";c"), ';');
    EXPECT_EQ(CsvRow::separator_of("\"a,b;c\"\td"), '\t');
    EXPECT_EQ(CsvRow::separator_of("\"a,b\" c"), ' ');
}

TEST(CsvRow, WhatIsWrittenReadsBack) {
    for (const std::string text : {"a", "a b", " a", "a ", "", "a,b", "\"", "say \"hi\"", "#a", "%a", ";", "a\tb"}) {
        CsvRow row(',');
        const std::string line = csv_field(text) + "," + csv_field(text);
        const auto fields = row.split(line, "f.csv", 1);
        ASSERT_TRUE(fields.has_value()) << text;
        EXPECT_EQ(Fields(fields->begin(), fields->end()), (Fields{text, text})) << line;
    }
}

}  // namespace
}  // namespace meld
