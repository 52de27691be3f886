/** @file
 * What an ITK reader holds, as an Image. For the few files that include ITK.
 */
#pragma once

#include <itkImageIOBase.h>

#include <functional>

#include "tools/hapticctl-import/image.h"

namespace hapticctl_import {

/** What else to look at once it is known how many bytes the values take, and before they are read. */
using BeforeValues = std::function<void(std::uint64_t bytes)>;

/** Reads information and values of the file that `io` was given. Throws ImportError; what ITK throws is put in words.
 */
[[nodiscard]] Image readWith(itk::ImageIOBase& io, const BeforeValues& before_values = {});

/** Throws ImportError if a NIfTI file has fewer bytes than its values take, or is gzip and damaged or cut short. */
void requireWholeNifti(const std::string& path, std::uint64_t values);

/** Without ITK's addresses and class names. */
[[nodiscard]] std::string inWords(const itk::ExceptionObject& error);

}  // namespace hapticctl_import
