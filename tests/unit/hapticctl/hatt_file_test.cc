// Models of the Haptic Texture Toolkit: units, coefficients, and refusals by name. The files here are made up.
#include "tools/hapticctl/file/hatt_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <numbers>
#include <vector>

#include "tools/hapticctl/failure.h"

namespace hapticctl {
namespace {

using ::testing::HasSubstr;

std::string model(double speed, double force, const std::string& lines) {
  return "<model><ARlsf>" + lines + "</ARlsf><var>0.25</var><speedMod>" + std::to_string(speed) +
         "</speedMod><forceMod>" + std::to_string(force) + "</forceMod></model>\n";
}
std::string good() {
  const std::string lines = "<value>0.5</value><value> 1.25\n</value>";
  return "<?xml version=\"1.0\"?><modelSet><mu>0.35</mu><numMod>3</numMod><numMACoeff>0</numMACoeff>"
         "<tri><value>1</value><value>2</value><value>3</value></tri>" +
         model(10, 0.5, lines) + model(200, 0.5, lines) + model(10, 2, lines) + "</modelSet>";
}
std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/** Line spectral frequencies by their definition: where P and Q vanish on the upper half of the unit circle. */
std::vector<double> lineSpectrum(const std::vector<double>& a) {
  const std::size_t p = a.size();
  std::vector<double> full{1};
  full.insert(full.end(), a.begin(), a.end());
  full.push_back(0);
  std::vector<double> found;
  for (const double sign : {1.0, -1.0}) {
    const auto value = [&](double w) {  // Symmetric polynomials are real, or imaginary, but for a phase.
      std::complex<double> sum = 0;
      for (std::size_t i = 0; i < full.size(); ++i) {
        const double half = static_cast<double>(i) - 0.5 * static_cast<double>(p + 1);
        sum += (full[i] + sign * full[p + 1 - i]) * std::polar(1.0, -w * half);
      }
      return sign > 0 ? sum.real() : sum.imag();
    };
    constexpr int kSteps = 20000;
    for (int i = 1; i < kSteps - 1; ++i) {
      double low = std::numbers::pi * i / kSteps, high = std::numbers::pi * (i + 1) / kSteps;
      if (value(low) * value(high) > 0) continue;
      for (int k = 0; k < 60; ++k) (value(low) * value(0.5 * (low + high)) <= 0 ? high : low) = 0.5 * (low + high);
      found.push_back(low);
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(HattFile, LineSpectraBecomeTheirPolynomial) {
  // Poles within the circle, of even and odd order.
  const std::vector<std::vector<double>> polynomials = {{-0.9}, {-1.2, 0.7}, {-1.5, 1.1, -0.3}, {0.2, 0.5, -0.1, 0.3}};
  for (const std::vector<double>& a : polynomials) {
    const std::vector<double> lines = lineSpectrum(a);
    ASSERT_EQ(lines.size(), a.size());
    const std::vector<double> back = fromLineSpectrum(lines);
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(back[i], a[i], 1e-9) << a.size() << ":" << i;
  }
}

TEST(HattFile, ReadsModelsInSiUnits) {
  const HattFile file = parseHatt(good(), "f");
  ASSERT_EQ(file.models.size(), 3u);
  EXPECT_DOUBLE_EQ(file.models[1].speed, 0.2);
  EXPECT_DOUBLE_EQ(file.models[2].force, 2);
  EXPECT_DOUBLE_EQ(file.models[0].variance, 0.25);
  EXPECT_EQ(file.models[0].a, fromLineSpectrum({0.5, 1.25}));
  EXPECT_DOUBLE_EQ(file.friction, 0.35);
  EXPECT_THAT(file.triangles, ::testing::ElementsAre(std::array<std::uint32_t, 3>{0, 1, 2}));
}

TEST(HattFile, EveryFaultIsNamed) {
  const struct {
    std::string text;
    const char* where;
    const char* what;
  } faults[] = {
      {"<modelSet>", "byte", ""},
      {"", "byte", ""},
      {"<model/>", "modelSet", "missing"},
      {with(good(), "<var>0.25</var>", ""), "model[1].var", "missing"},
      {with(good(), "0.25", "1,5"), "model[1].var", "'1,5'"},
      {with(good(), "<value>0.5</value>", "<value>2</value>"), "model[1].ARlsf.value[2]", "rise within"},
      {with(good(), "<value>0.5</value>", "<value>nan</value>"), "model[1].ARlsf.value[1]", "not a number"},
      {with(good(), "<value>0.5</value>", ""), "model[2].ARlsf", "the first model 1"},
      {with(good(), "<numMACoeff>0", "<numMACoeff>4"), "numMACoeff", "moving-average"},
      {with(good(), "<value>3</value></tri>", "</tri>"), "tri[1]", "2 corners"},
      {with(good(), "<value>3</value></tri>", "<value>4</value></tri>"), "tri[1].value[3]", "count from 1 to 3"},
      {with(good(), "<value>1</value>", "<value>0</value>"), "tri[1].value[1]", "no model"},
      {with(good(), "<value>1</value>", "<value>1.5</value>"), "tri[1].value[1]", "no model"},
      {with(good(), "<tri><value>1</value><value>2</value><value>3</value></tri>", ""), "tri", "missing"},
      {"<modelSet><mu>x</mu></modelSet>", "mu", "not a number"},
      {"<modelSet/>", "model", "3 are the least"},
  };
  for (const auto& fault : faults) {
    try {
      (void)parseHatt(fault.text, "some.xml");
      ADD_FAILURE() << "taken: " << fault.where;
    } catch (const Failure& failure) {
      EXPECT_EQ(failure.exit, kExitFile);
      EXPECT_THAT(failure.where, HasSubstr("some.xml: " + std::string(fault.where)));
      EXPECT_THAT(failure.what, HasSubstr(fault.what));
    }
  }
}

}  // namespace
}  // namespace hapticctl
