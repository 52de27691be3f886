#include "daemon/resource/resource_name.h"

#include <gmock/gmock.h>

namespace hapticd {
namespace {

using testing::ElementsAre;
using testing::Pair;

TEST(ResourceName, SplitsPathAndQuery) {
  const auto name = parseResourceName("/objects/motor/pos?value=1,2,3&unit=m");
  ASSERT_TRUE(name.ok());
  EXPECT_THAT(name->element, ElementsAre("objects", "motor", "pos"));
  EXPECT_THAT(name->query, ElementsAre(Pair("value", "1,2,3"), Pair("unit", "m")));
  EXPECT_EQ(*name->find("value"), "1,2,3");
  EXPECT_EQ(name->find("missing"), nullptr);
  EXPECT_EQ(name->upTo(1), "/objects/motor");
}

TEST(ResourceName, TakesRootFoldersAndEscapes) {
  EXPECT_TRUE(parseResourceName("/")->element.empty());
  EXPECT_THAT(parseResourceName("/objects/")->element, ElementsAre("objects"));
  EXPECT_THAT(parseResourceName("/a%2fb?x=%26")->element, ElementsAre("a/b"));
  EXPECT_EQ(*parseResourceName("/a%2fb?x=%26")->find("x"), "&");
  EXPECT_EQ(*parseResourceName("/a?x=")->find("x"), "");
}

TEST(ResourceName, NamesTheByteAtFault) {
  const auto where = [](std::string_view text) {
    const auto r = parseResourceName(text);
    if (r.ok()) return std::string("accepted");
    EXPECT_FALSE(r.error().remedy.empty()) << toString(r.error());
    return r.error().where;
  };
  EXPECT_EQ(where(""), "byte 0");
  EXPECT_EQ(where("objects"), "byte 0");
  EXPECT_EQ(where("/a//b"), "byte 3");
  EXPECT_EQ(where("/a%2"), "byte 2");
  EXPECT_EQ(where("/a%zz"), "byte 2");
  EXPECT_EQ(where("/a%00"), "byte 2");
  EXPECT_EQ(where(std::string_view("/a\0b", 4)), "byte 2");
  EXPECT_EQ(where("/a\xc3\xa9"), "byte 2");
  EXPECT_EQ(where("/a?value"), "byte 3");
  EXPECT_EQ(where("/a?=1"), "byte 3");
  EXPECT_EQ(where("/a?x=1&x=2"), "byte 7");
  EXPECT_EQ(where("/" + std::string(kMaxResourceName, 'a')), "byte 4096");
  std::string deep;
  for (std::size_t i = 0; i <= kMaxResourceElements; ++i) deep += "/a";
  EXPECT_EQ(where(deep), "byte 129");
}

TEST(Numbers, AreFiniteLocaleFreeAndCounted) {
  EXPECT_THAT(*parseNumbers("1,-2.5,3e-3", 3, "x"), ElementsAre(1.0, -2.5, 0.003));
  EXPECT_THAT(*parseNumbers(" 1 , 2 ", 2, "x"), ElementsAre(1.0, 2.0));
  EXPECT_THAT(*parseNumbers("+1000,+2e-3,-1", 3, "x"), ElementsAre(1000.0, 0.002, -1.0));
  for (const char* bad : {"+-1,0", "++1,0", "+,0", "+inf,0"}) EXPECT_FALSE(parseNumbers(bad, 2, "x").ok()) << bad;
  for (const char* bad : {"", "1,", ",1", "1,2,3", "nan,0", "inf,0", "1e999,0", "1;2", "1,5 2", "0x10,1", "a,b"}) {
    EXPECT_FALSE(parseNumbers(bad, 2, "x").ok()) << bad;
  }
  EXPECT_EQ(parseNumbers("1,x,3", 3, "/objects/a/pos").error().where, "/objects/a/pos");
  EXPECT_NE(parseNumbers("1,x,3", 3, "p").error().what.find("number 2"), std::string::npos);
  EXPECT_FALSE(parseNumbers(std::string(100'000, ','), 3, "x").ok());
  EXPECT_EQ(toString(parseNumbers("1,2", 1, "p").error()),
            "p: one number is needed, not at least 2 (give one number in SI units, with '.' as the decimal point)");
  EXPECT_EQ(
      toString(parseNumbers("1,2", 3, "p").error()),
      "p: 3 numbers are needed, not 2 (give 3 numbers separated by commas in SI units, with '.' as the decimal point)");
}

TEST(Bool, HasThreeWordsForEach) {
  for (const char* yes : {"true", "1", "on"}) EXPECT_TRUE(*parseBool(yes, "x"));
  for (const char* no : {"false", "0", "off"}) EXPECT_FALSE(*parseBool(no, "x"));
  for (const char* bad : {"", "yes", "TRUE", "2"}) EXPECT_FALSE(parseBool(bad, "x").ok());
}

}  // namespace
}  // namespace hapticd
