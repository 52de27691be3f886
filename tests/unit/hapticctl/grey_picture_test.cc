#include "tools/hapticctl/file/grey_picture.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "tests/support/process/temporary_directory.h"
#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class GreyPictureTest : public ::testing::Test {
 protected:
  /** Two by two pixels, or others, written by libpng's simplified interface. */
  template <class Sample>
  std::string png(png_uint_32 format, const std::vector<Sample>& samples, png_uint_32 width = 2,
                  png_uint_32 height = 2) {
    png_image image;
    std::memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = format;
    const std::string path = (directory_ / "picture.png").string();
    EXPECT_NE(png_image_write_to_file(&image, path.c_str(), 0, samples.data(), 0, nullptr), 0) << image.message;
    return path;
  }
  std::string refusal(const std::string& path) {
    try {
      (void)readPng(path);
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.exit, kExitFile);
      EXPECT_EQ(failure.where, path);
      return failure.what;
    }
    return "taken";
  }
  hapticd::test::TemporaryDirectory temporary_;
  const std::filesystem::path directory_ = temporary_.path();
};

TEST_F(GreyPictureTest, EightBitsOfGreyFillTheRange) {
  const GreyPicture p = readPng(png<std::uint8_t>(PNG_FORMAT_GRAY, {0, 1, 128, 255}));
  EXPECT_EQ(p.width, 2u);
  EXPECT_EQ(p.height, 2u);
  EXPECT_THAT(p.grey, ElementsAre(0, 257, 128 * 257, 65535));
}

TEST_F(GreyPictureTest, ColoursBecomeTheirLuminance) {
  const GreyPicture p = readPng(png<std::uint8_t>(PNG_FORMAT_RGB, {255, 255, 255, 0, 0, 0, 0, 255, 0, 100, 100, 100}));
  ASSERT_EQ(p.grey.size(), 4u);
  EXPECT_EQ(p.grey[0], 65535);
  EXPECT_EQ(p.grey[1], 0);
  EXPECT_NEAR(p.grey[2] / 65535.0, 0.715, 0.002) << "green, by the weights of BT.709";
  EXPECT_NEAR(p.grey[3], 100 * 257, 2);
}

TEST_F(GreyPictureTest, WhatIsTransparentIsTheSurface) {
  const GreyPicture p =
      readPng(png<std::uint8_t>(PNG_FORMAT_RGBA, {0, 0, 0, 0, 0, 0, 0, 255, 9, 9, 9, 0, 255, 255, 255, 255}));
  EXPECT_EQ(p.grey[0], 65535);
  EXPECT_EQ(p.grey[1], 0);
  EXPECT_EQ(p.grey[2], 65535);
}

TEST_F(GreyPictureTest, WhatIsNoPictureIsRefusedByName) {
  EXPECT_THAT(refusal((directory_ / "none.png").string()), HasSubstr("no such file"));
  const std::string text = (directory_ / "text.png").string();
  std::ofstream(text) << "hello, I am no picture at all";
  EXPECT_THAT(refusal(text), HasSubstr("not a PNG"));
  const std::string whole = png<std::uint8_t>(PNG_FORMAT_GRAY, {0, 1, 128, 255});
  std::filesystem::resize_file(whole, std::filesystem::file_size(whole) - 20);
  EXPECT_THAT(refusal(whole), HasSubstr("damaged"));
  for (const auto& [width, height] : {std::pair{1u, 2u}, std::pair{4097u, 2u}, std::pair{2u, 5000u}}) {
    EXPECT_EQ(refusal(png(PNG_FORMAT_GRAY, std::vector<std::uint8_t>(width * height), width, height)),
              fmt::format("it has {} x {} pixels", width, height));
  }
}

}  // namespace
}  // namespace hapticctl
