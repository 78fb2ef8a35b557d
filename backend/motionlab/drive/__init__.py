"""The drive link: six CiA 402 current drives on EtherCAT, and a virtual drive to try it on."""
