#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "drivers/registry.h"
#include "tests/support/seeds.h"

namespace hapticd {
namespace {

using ::testing::HasSubstr;

TEST(DeviceUri, ReadsSchemeAuthorityAndQueryInOrder) {
  Result<DeviceUri> uri = parseDeviceUri("SIM://default?b=2&a=1,2,3&c=");
  ASSERT_TRUE(uri.ok()) << toString(uri.error());
  EXPECT_EQ(uri->scheme, "sim");
  EXPECT_EQ(uri->authority, "default");
  ASSERT_EQ(uri->query.size(), 3u);
  EXPECT_EQ(uri->query[0], (std::pair<std::string, std::string>("b", "2")));
  EXPECT_EQ(uri->query[1], (std::pair<std::string, std::string>("a", "1,2,3")));
  EXPECT_EQ(uri->query[2], (std::pair<std::string, std::string>("c", "")));
}

TEST(DeviceUri, AuthorityMayBeEmptyOrAPath) {
  EXPECT_EQ(parseDeviceUri("sim://")->authority, "");
  EXPECT_EQ(parseDeviceUri("sim://?")->authority, "");
  EXPECT_EQ(parseDeviceUri("replay:///var/lib/a b.csv")->authority, "/var/lib/a b.csv");
  EXPECT_EQ(parseDeviceUri("replay:///w%C3%A4nde%3F%26%25.csv?speed=2")->authority, "/w\xc3\xa4nde?&%.csv");
}

TEST(DeviceUri, FaultsNameTheCharacter) {
  struct Case {
    std::string uri;
    std::string says;
  };
  const std::vector<Case> cases = {
      {"", "no \"://\""},
      {"default", "no \"://\""},
      {"://x", "no scheme"},
      {"1sim://x", "character 1: '1' in a scheme"},
      {"si m://x", "character 3: byte 0x20 in a scheme"},
      {"sim://x?a", "\"a\" has no value"},
      {"sim://x?a=1&", "character 13: an empty key=value pair"},
      {"sim://x?&a=1", "character 9: an empty"},
      {"sim://x?=1", "a value without a key"},
      {"sim://x?a b=1", "character 10: byte 0x20 in a key"},
      {"sim://x?a=1&a=2", "character 13: the key \"a\" is given twice"},
      {"sim://x?a=%4", "character 11: '%' is not followed"},
      {"sim://x?a=%zz", "'%' is not followed"},
      {"sim://x%00", "a control character"},
      {"sim://x\n", "byte 0x0a"},
      {"sim://x#frag", "write %23"},
      {"sim://" + std::string(5000, 'x'), "longer than 4096"},
  };
  for (const Case& c : cases) {
    Result<DeviceUri> uri = parseDeviceUri(c.uri);
    ASSERT_FALSE(uri.ok()) << c.uri;
    EXPECT_EQ(uri.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(toString(uri.error()), HasSubstr(c.says)) << c.uri;
    EXPECT_FALSE(uri.error().remedy.empty()) << c.uri;
  }
}

TEST(DeviceUri, AnythingThatFormatsParsesBack) {
  std::mt19937 random(seedOf(1));
  std::uniform_int_distribution<int> byte(0x20, 0xff), size(0, 12);
  const auto text = [&] {
    std::string out;
    for (int i = size(random); i > 0; --i) {
      const int b = byte(random);
      if (b != 0x7f) out.push_back(static_cast<char>(b));
    }
    return out;
  };
  for (int i = 0; i < 2000; ++i) {
    DeviceUri uri{"sim", text(), {{"key-1", text()}, {"k.2", text()}}};
    const std::string formatted = formatDeviceUri(uri);
    Result<DeviceUri> again = parseDeviceUri(formatted);
    ASSERT_TRUE(again.ok()) << formatted << " " << toString(again.error());
    EXPECT_EQ(again->authority, uri.authority);
    EXPECT_EQ(again->query, uri.query);
  }
}

}  // namespace
}  // namespace hapticd
