# Installation and package configuration.
