#include "tools/hapticctl/file/grey_picture.h"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstdio>
#include <memory>

#include "tools/hapticctl/exit_code.h"
#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

constexpr std::uint32_t kLeastSide = 2, kMostSide = 4096;  // What the daemon takes; more is not even unpacked.

[[noreturn]] void failFile(const std::string& path, const std::string& what, const std::string& remedy = {}) {
  throw Failure{kExitFile, path, what, remedy, "BAD_PICTURE"};
}

/** libpng's state; its errors come back by longjmp, its words by `message`. */
struct PngReader {
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::array<char, 160> message{};

  PngReader() {
    png = png_create_read_struct(
        PNG_LIBPNG_VER_STRING, this,
        [](png_structp p, png_const_charp text) {
          auto* self = static_cast<PngReader*>(png_get_error_ptr(p));
          std::snprintf(self->message.data(), self->message.size(), "%s", text);
          png_longjmp(p, 1);
        },
        [](png_structp, png_const_charp) {});
    if (png != nullptr) info = png_create_info_struct(png);
  }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;
  ~PngReader() { png_destroy_read_struct(&png, &info, nullptr); }
};

/** Whatever the file holds becomes 16 bits of grey, or of red, green and blue. After the header was read. */
void askForSixteenBits(png_structp png, png_infop info) {
  const png_byte colour = png_get_color_type(png, info);
  if (colour == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (colour == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(png);
  if (png_get_valid(png, info, PNG_INFO_tRNS) != 0) png_set_tRNS_to_alpha(png);
  png_set_expand_16(png);
  png_color_16 white{0, 65535, 65535, 65535, 65535};
  png_set_background(png, &white, PNG_BACKGROUND_GAMMA_SCREEN, 0, 1);
  png_set_swap(png);  // The machine's order.
  (void)png_set_interlace_handling(png);
  png_read_update_info(png, info);
}

/** False when libpng gave up. No object with a destructor lives here: it returns by longjmp. */
bool readHeader(PngReader& reader, std::FILE* file) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_init_io(reader.png, file);
  png_read_info(reader.png, reader.info);
  askForSixteenBits(reader.png, reader.info);
  return true;
}

bool readRows(PngReader& reader, png_bytepp rows) {
  if (setjmp(png_jmpbuf(reader.png)) != 0) return false;
  png_read_image(reader.png, rows);
  png_read_end(reader.png, nullptr);
  return true;
}

/** By the weights of ITU-R BT.709, on the values as they stand. */
void toLuminance(std::vector<std::uint16_t>& samples) {
  for (std::size_t i = 0; i < samples.size() / 3; ++i) {
    const double grey = 0.2126 * samples[3 * i] + 0.7152 * samples[3 * i + 1] + 0.0722 * samples[3 * i + 2];
    samples[i] = static_cast<std::uint16_t>(grey + 0.5);
  }
  samples.resize(samples.size() / 3);
}

}  // namespace

GreyPicture readPng(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), &std::fclose);
  if (file == nullptr) failFile(path, "no such file, or it cannot be read");
  PngReader reader;
  if (reader.info == nullptr) failFile(path, "there is no memory for libpng");
  if (!readHeader(reader, file.get())) {
    failFile(path, fmt::format("it is not a PNG that can be read: {}", reader.message.data()),
             "convert it to PNG, at most 4096 pixels a side");
  }
  GreyPicture picture;
  picture.width = png_get_image_width(reader.png, reader.info);
  picture.height = png_get_image_height(reader.png, reader.info);
  const auto [least, most] = std::minmax(picture.width, picture.height);
  if (least < kLeastSide || most > kMostSide) {
    failFile(path, fmt::format("it has {} x {} pixels", picture.width, picture.height),
             fmt::format("make it {} to {} pixels a side", kLeastSide, kMostSide));
  }
  const std::size_t row = png_get_rowbytes(reader.png, reader.info) / sizeof(std::uint16_t);
  const std::size_t channels = row / picture.width;
  if (row % picture.width != 0 || (channels != 1 && channels != 3))
    failFile(path, "its kind of colour is not known", "convert it to grey");
  picture.grey.resize(row * picture.height);
  std::vector<png_bytep> rows(picture.height);
  for (std::uint32_t y = 0; y < picture.height; ++y) {
    rows[y] = reinterpret_cast<png_bytep>(picture.grey.data() + y * row);
  }
  if (!readRows(reader, rows.data())) {
    failFile(path, fmt::format("the picture is damaged: {}", reader.message.data()));
  }
  if (channels == 3) toLuminance(picture.grey);
  return picture;
}

}  // namespace hapticctl
