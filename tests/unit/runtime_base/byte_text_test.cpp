#include "runtime/base/byte_text.h"

#include <gtest/gtest.h>

namespace meld {
namespace {

TEST(ByteText, GivesEveryByteBack) {
    std::string all;
    for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
    EXPECT_EQ(bytes_of_text(text_of_bytes(all)), all);
}

TEST(ByteText, IsUtf8) {
    EXPECT_EQ(text_of_bytes("plain\n"), "plain\n");
    EXPECT_EQ(text_of_bytes("\x80\xe9\xff"), "\xc2\x80\xc3\xa9\xc3\xbf");
}

}  // namespace
}  // namespace meld
