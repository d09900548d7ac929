// Pieces of a self-contained HTML page: one style, tables, folded parts. Texts are escaped, `html` is not.
#pragma once

#include <string>
#include <vector>

namespace wheel_twin::twin::page {

std::string escaped(const std::string& text);
std::string document(const std::string& title, const std::string& html);
std::string heading(const std::string& title, const std::string& subtitle);
std::string paragraph(const std::string& text);
std::string note(const std::string& text);  ///< small print
std::string row(const std::vector<std::string>& cells);
/// `rows` made of row(). The first column reads from the left, numbers from the right.
std::string table(const std::vector<std::string>& head, const std::string& rows);
std::string folded(const std::string& summary, const std::string& html);
/// Two pictures side by side; either may be empty.
std::string pair(const std::string& left, const std::string& right);

}  // namespace wheel_twin::twin::page
