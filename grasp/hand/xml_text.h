/// What writers of XML share. Internal to the library.
#pragma once

#include <string>
#include <tinyxml2.h>
#include <utility>
#include <vector>

namespace bullet_ccd::grasp
{
/// A base of writers: elements with attributes, in the order given.
class XmlText
{
protected:
    using Attributes = std::vector<std::pair<const char*, std::string>>;

    void open(const char* name, const Attributes& attributes)
    {
        m_printer.OpenElement(name);
        for (const auto& [key, value] : attributes)
        {
            m_printer.PushAttribute(key, value.c_str());
        }
    }

    void element(const char* name, const Attributes& attributes)
    {
        open(name, attributes);
        m_printer.CloseElement();
    }

    tinyxml2::XMLPrinter m_printer;
};
}  // namespace bullet_ccd::grasp
