module fba-decoder

go 1.21
